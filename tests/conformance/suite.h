// What every case has: a broker at an address of the family under test, clients of unique names,
// topics that no other case uses, and a way to know that nothing came.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "tests/conformance/broker.h"
#include "tests/conformance/client.h"

namespace romano::conformance {

using namespace std::chrono_literals;

template <Kind kind>
class Suite : public testing::TestWithParam<Endpoint::Family> {
protected:
    void SetUp() override {
        broker_ = broker_at(kind, GetParam());
        if (!broker_) GTEST_SKIP() << "the broker under test has no such address or limits";
    }
    void TearDown() override {
        if (!broker_) return;
        for (const std::string& name : retained_) {  // leaves nothing behind
            Client& cleaner = client();
            cleaner.connects();
            cleaner.publishes(cleaner.registers(name), "", 1, retain);
        }
    }

    /// A new client, not connected; it lives until the case ends.
    Client& client() { return client(unique("c")); }
    Client& client(const std::string& client_id) {
        clients_.push_back(std::make_unique<Client>(*broker_, client_id));
        return *clients_.back();
    }
    /// A new client that is connected.
    Client& connected(Flags flags = clean, unsigned duration_s = 0) {
        Client& one = client();
        one.connects(flags, duration_s);
        return one;
    }

    /// All that was said so far has had its effect: the broker answers somebody who asked later.
    void settle() {
        if (witness_ == nullptr) {
            witness_ = &connected();
        }
        witness_->says(pingreq());
        witness_->hears(pingresp());
    }
    /// Nothing is there for it, nor will be without a reason.
    void hears_nothing(Client& who) {
        settle();
        EXPECT_EQ(describe(who.next(agreement().quiet)), "nothing") << who.id;
    }

    /// A name that no other case and no earlier run has.
    static std::string unique(const std::string& name) {
        static int counter = 0;
        return name + std::to_string(getpid()) + "-" + std::to_string(++counter);
    }
    /// The case's own topic.
    [[nodiscard]] std::string topic(const std::string& name = "t") const { return root_ + name; }

    /// Retains a message, which is taken back when the case ends.
    void retains(Client& publisher, const std::string& name, const std::string& data, int qos = 0) {
        publisher.publishes(publisher.registers(name), data, qos, retain);
        retained_.push_back(name);
    }
    void forget_retained(const std::string& name) { retained_.push_back(name); }

    [[nodiscard]] const Endpoint& address() const { return *broker_; }

private:
    std::optional<Endpoint> broker_;
    std::string root_ = unique("r") + "/";
    std::vector<std::string> retained_;
    std::vector<std::unique_ptr<Client>> clients_;
    Client* witness_ = nullptr;
};

using PatientSuite = Suite<Kind::patient>;
using ImpatientSuite = Suite<Kind::impatient>;
using NarrowSuite = Suite<Kind::narrow>;

inline std::string family_name(const testing::TestParamInfo<Endpoint::Family>& info) {
    return info.param == Endpoint::Family::ipv6 ? "Ipv6" : "Ipv4";
}

}  // namespace romano::conformance

/// A chapter of the specification: its cases are TEST_P(suite, rule_What), over both families.
#define CONFORMANCE_SUITE(suite, base)                                                        \
    class suite : public base {}; /* NOLINT(bugprone-macro-parentheses): names */             \
    INSTANTIATE_TEST_SUITE_P(Conformance, suite,                                              \
                             testing::Values(Endpoint::Family::ipv4, Endpoint::Family::ipv6), \
                             family_name)
