// A lone broker with a store: kill -9 at any moment loses nothing that it acknowledged, and its
// clients notice nothing but a pause.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <random>
#include <set>
#include <thread>

#include "romano/base/random.h"
#include "tests/system/broker_process.h"
#include "tests/system/test_addresses.h"
#include "tests/system/test_client.h"
#include "tests/temporary_folder.h"

namespace romano::system::persistence_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

/// ROMANO_TEST_SEED, or another one each time.
std::uint64_t test_seed() {
    const char* given = std::getenv("ROMANO_TEST_SEED");
    return given != nullptr ? std::strtoull(given, nullptr, 10) : std::random_device{}();
}

struct Persistence : testing::Test {
    [[nodiscard]] std::unique_ptr<BrokerProcess> start(std::vector<std::string> more = {}) const {
        std::vector<std::string> arguments = {"--listen", addresses.service(1), "--store", path};
        arguments.insert(arguments.end(), more.begin(), more.end());
        auto broker = std::make_unique<BrokerProcess>(arguments);
        broker->wait_until_serving();
        return broker;
    }
    [[nodiscard]] std::unique_ptr<TestClient> client(const std::string& id) const {
        return std::make_unique<TestClient>(addresses.client(), addresses.service_endpoint(1), id);
    }

    TestAddresses addresses;
    tests::TemporaryFolder folder;
    std::string path = folder / "store.db";
};

/// Each in the order of its first coming.
std::vector<std::string> data_of(const TestClient& client) {
    std::vector<std::string> found;
    for (const auto& publish : client.received) found.push_back(publish.data);
    return found;
}

std::vector<std::string> without_repetitions(const std::vector<std::string>& list) {
    std::vector<std::string> found;
    std::set<std::string> seen;
    for (const auto& item : list) {
        if (seen.insert(item).second) found.push_back(item);
    }
    return found;
}

TEST_F(Persistence, NothingAcknowledgedIsLostThoughTheBrokerIsKilledAtRandomMomentsUnderLoad) {
    constexpr int kills = 12;
    const std::uint64_t seed = test_seed();
    SCOPED_TRACE("ROMANO_TEST_SEED=" + std::to_string(seed));
    std::printf("ROMANO_TEST_SEED=%llu\n", static_cast<unsigned long long>(seed));

    auto broker = start();
    const auto exactly_once = client("exactly-once");
    const auto at_least_once = client("at-least-once");
    const auto late = client("late");
    const auto publisher = client("publisher");
    publisher->repeats_after = 20ms;
    ASSERT_TRUE(exactly_once->connect(false));
    ASSERT_TRUE(exactly_once->subscribe("pose/+", Qos::exactly_once));
    ASSERT_TRUE(at_least_once->connect(true));  // a clean session that is connected goes on too
    ASSERT_TRUE(at_least_once->subscribe("pose/+", Qos::at_least_once));
    ASSERT_TRUE(late->connect(false));
    ASSERT_TRUE(late->subscribe("pose/two", Qos::exactly_once));
    ASSERT_TRUE(publisher->connect(false));
    const auto one = publisher->register_topic("pose/one");
    const auto two = publisher->register_topic("pose/two");
    ASSERT_TRUE(one && two);
    const std::vector<int> begun = {exactly_once->sessions_begun, at_least_once->sessions_begun,
                                    publisher->sessions_begun};

    std::atomic<bool> killing = true;
    std::atomic<bool> publishing = true;
    const auto serve = [&](TestClient& subscriber) {
        while (publishing) subscriber.run_until([&] { return !publishing; }, 20ms);
    };
    std::thread serving_one([&] { serve(*exactly_once); });
    std::thread serving_two([&] { serve(*at_least_once); });
    std::vector<std::string> published;
    std::thread publishing_all([&] {
        while (killing && !HasFailure()) {
            const bool first = published.size() % 2 == 0;
            const std::string data = std::to_string(published.size());
            const Qos qos = first ? Qos::at_least_once : Qos::exactly_once;
            EXPECT_TRUE(publisher->publish(first ? *one : *two, data, qos)) << data;
            published.push_back(data);
        }
        publishing = false;
    });

    Random random{seed};
    for (int i = 0; i < kills && !HasFailure(); ++i) {
        std::this_thread::sleep_for(std::chrono::microseconds{random.below(200'000)});
        broker->kill_9();
        broker = start();  // by this thread: a process dies with the thread that started it
    }
    killing = false;
    publishing_all.join();
    serving_one.join();
    serving_two.join();
    std::printf("%zu published\n", published.size());

    // The broker's Tretry is ten seconds: what was in flight last may need one.
    const auto last_came = [&](const TestClient& at) {
        return without_repetitions(data_of(at)).size() >= published.size();
    };
    EXPECT_TRUE(exactly_once->run_until([&] { return last_came(*exactly_once); }, 30s));
    EXPECT_TRUE(at_least_once->run_until([&] { return last_came(*at_least_once); }, 30s));
    EXPECT_EQ(without_repetitions(data_of(*at_least_once)), published);
    std::vector<std::string> twos;
    std::vector<std::string> of_qos2;
    for (std::size_t i = 1; i < published.size(); i += 2) twos.push_back(published[i]);
    for (const auto& publish : exactly_once->received) {
        if (publish.qos == Qos::exactly_once) of_qos2.push_back(publish.data);
    }
    EXPECT_EQ(of_qos2, twos) << "exactly once and in order";
    EXPECT_EQ((std::vector<int>{exactly_once->sessions_begun, at_least_once->sessions_begun,
                                publisher->sessions_begun}),
              begun)
        << "a client noticed";
}

TEST_F(Persistence, WhatWaitsForASleeperAndWhatIsRetainedOutlivesTheProcess) {
    auto broker = start();
    {
        const auto away = client("away");
        const auto publisher = client("publisher");
        ASSERT_TRUE(away->connect(false));
        ASSERT_TRUE(away->subscribe("log", Qos::exactly_once));
        ASSERT_TRUE(away->disconnect());
        ASSERT_TRUE(publisher->connect());
        const auto log = publisher->register_topic("log");
        const auto map = publisher->register_topic("map");
        ASSERT_TRUE(log && map);
        for (int i = 0; i < 20; ++i) {
            ASSERT_TRUE(publisher->publish(*log, std::to_string(i), Qos::exactly_once));
        }
        ASSERT_TRUE(publisher->publish(*map, "of the hall", Qos::at_least_once, true));
    }
    broker->kill_9();
    broker = start();
    const auto back = client("away");
    ASSERT_TRUE(back->connect(false));
    EXPECT_TRUE(back->run_until([&] { return back->received.size() >= 20; }));
    for (std::size_t i = 0; i < back->received.size(); ++i) {
        EXPECT_EQ(back->received[i].data, std::to_string(i));
    }
    const auto reader = client("reader");
    ASSERT_TRUE(reader->connect());
    ASSERT_TRUE(reader->subscribe("map", Qos::at_least_once));
    EXPECT_TRUE(reader->run_until([&] { return !reader->received.empty(); }));
    EXPECT_EQ(reader->received.front().data, "of the hall");
    EXPECT_TRUE(reader->received.front().retain);
}

TEST_F(Persistence, AFullStoreIsAnsweredByCongestionAndSaidOnce) {
    auto broker = start({"--store-limit-mb", "1"});
    const auto away = client("away");
    const auto publisher = client("publisher");
    ASSERT_TRUE(away->connect(false));
    ASSERT_TRUE(away->subscribe("log", Qos::at_least_once));
    ASSERT_TRUE(away->disconnect());
    ASSERT_TRUE(publisher->connect());
    const auto topic = publisher->register_topic("log");
    ASSERT_TRUE(topic);
    const std::string chunk(20'000, 'x');
    std::size_t kept = 0;
    while (kept < 100 &&
           publisher->publish(*topic, chunk + std::to_string(kept), Qos::at_least_once)) {
        ++kept;
    }
    EXPECT_GT(kept, 10U);
    EXPECT_LT(kept, 60U);
    const auto newcomer = client("newcomer");
    EXPECT_FALSE(newcomer->connect()) << "a promise that cannot be kept";
    const std::string errors = broker->errors();
    EXPECT_THAT(errors, testing::HasSubstr("congestion"));
    EXPECT_EQ(errors.find("congestion"), errors.rfind("congestion")) << "said more than once";

    broker->kill_9();  // all that was acknowledged is there
    broker = start({"--store-limit-mb", "100"});
    const auto back = client("away");
    ASSERT_TRUE(back->connect(false));
    EXPECT_TRUE(back->run_until([&] { return back->received.size() >= kept; }));
}

TEST_F(Persistence, WhileTheStoreIsFullRequestsAreRefusedAndQos0StillComes) {
    const auto broker = start({"--store-limit-mb", "1"});
    const auto away = client("away");
    const auto publisher = client("publisher");
    const auto watcher = client("watcher");
    ASSERT_TRUE(away->connect(false));
    ASSERT_TRUE(away->subscribe("log", Qos::at_least_once));
    ASSERT_TRUE(away->disconnect());
    ASSERT_TRUE(watcher->connect());
    ASSERT_TRUE(watcher->subscribe("pose", Qos::at_most_once));
    ASSERT_TRUE(publisher->connect());
    const auto log = publisher->register_topic("log");
    const auto pose = publisher->register_topic("pose");
    ASSERT_TRUE(log && pose);
    const std::string chunk(20'000, 'x');
    for (int kept = 0; publisher->publish(*log, chunk, Qos::at_least_once); ++kept) {
        ASSERT_LT(kept, 100);
    }
    const auto pose_comes = [&] {
        watcher->received.clear();
        return publisher->publish(*pose, "x", Qos::at_most_once) &&
               watcher->run_until([&] { return !watcher->received.empty(); }, 5s);
    };
    watcher->send_octets(watcher->sealed(
        mqttsn::Register{.topic_id = {}, .msg_id = mqttsn::MsgId{99}, .topic_name = "new"}));
    EXPECT_TRUE(watcher->ping());
    EXPECT_TRUE(pose_comes());
    const auto before = std::chrono::steady_clock::now();
    EXPECT_FALSE(watcher->subscribe("log", Qos::at_least_once));
    EXPECT_LT(std::chrono::steady_clock::now() - before, 5s) << "congestion was not heard";
    EXPECT_TRUE(pose_comes());
}

TEST_F(Persistence, AnImpossibleStoreIsRefusedWithExitCode2) {
    std::ofstream(path) << "a diary";
    BrokerProcess broker({"--listen", addresses.service(1), "--store", path});
    EXPECT_EQ(broker.wait_for_exit(), 2);
    EXPECT_THAT(broker.errors(), testing::StartsWith("romano-broker: --store '" + path + "': is"));
    EXPECT_EQ(broker.next_line(), "");
    BrokerProcess clustered({"--listen", addresses.service(1), "--store", path, "--domain",
                             std::to_string(addresses.domain())});
    EXPECT_EQ(clustered.wait_for_exit(), 2);
    EXPECT_THAT(clustered.errors(), testing::HasSubstr("is for a broker alone"));
}

}  // namespace
}  // namespace romano::system::persistence_test
