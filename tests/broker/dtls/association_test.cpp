// One client and several brokers that speak by one association: every number once, no record of the
// client twice, and the client never takes an heir's records for old ones.

#include "broker/dtls/association.h"

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "romano/base/random.h"

namespace romano::dtls::association_test {
namespace {

using Octets = std::vector<std::uint8_t>;

const RecordKeys keys{Suite::aes_128_ccm_8, {{1}, {2}}, {{3}, {4}}};
const Octets message{2, 22};

/// A broker, its disk, and its copy of the association.
struct Broker {
    explicit Broker(std::uint32_t its_place) : place(its_place) { store(); }

    void store() {
        if (const auto wanted = reserve.to_store()) {
            bound = *wanted;
            reserve.on_stored(*wanted);
        }
    }
    void learn(const Progress& progress) {
        association.emplace(AssociationId{7}, Path{}, keys, progress, Speaker{place, reserve});
    }
    void crash() {
        association.reset();
        reserve = protection::Reserve{bound};
        store();
    }
    /// The number of the record; nothing when there is none.
    std::optional<std::uint64_t> speak() {
        Octets out(100);
        const auto size = association->seal(cipher, {place, reserve}, ContentType::application_data,
                                            message, out);
        store();
        if (!size) return std::nullopt;
        return first_record(Bytes{out}.first(*size))->number;
    }
    bool hear(std::uint64_t number) {
        Octets record(100);
        record.resize(cipher.seal(keys.suite, keys.client, ContentType::application_data, number,
                                  message, record));
        Octets out(100);
        return association->open(cipher, *first_record(record), out).has_value();
    }

    std::uint32_t place;
    std::uint32_t bound = 0;
    protection::Reserve reserve{0};
    RecordCipher cipher;
    std::optional<Association> association;
};

struct SpokenBySome : testing::Test {
    SpokenBySome() { a.association.emplace(AssociationId{7}, Path{}, keys); }
    Broker a{1};
    Broker b{2};
};

TEST_F(SpokenBySome, TheHeirsNumbersAreHigherAndSoAreThoseAfterTheHandBack) {
    const auto first = a.speak();
    b.learn(a.association->progress());
    const auto heirs = b.speak();
    EXPECT_GT(heirs, first);
    a.association->on_told(b.association->progress());
    const auto back = a.speak();
    EXPECT_GT(back, heirs);
    EXPECT_EQ(*a.speak(), *back + 1) << "no new turn for each record";
}

TEST_F(SpokenBySome, WhatABrokerTellsOfItsOwnTurnEndsNobodys) {
    const auto first = a.speak();
    b.learn(a.association->progress());
    EXPECT_FALSE(a.association->on_told(b.association->progress()));
    EXPECT_EQ(*a.speak(), *first + 1);
}

TEST_F(SpokenBySome, AnHeirTakesNothingTwiceThatWasTold) {
    EXPECT_TRUE(a.hear(1));
    EXPECT_TRUE(a.hear(2));
    EXPECT_FALSE(a.hear(2));
    b.learn(a.association->progress());
    EXPECT_FALSE(b.hear(1));
    EXPECT_FALSE(b.hear(2));
    EXPECT_TRUE(b.hear(3));
}

TEST_F(SpokenBySome, WhatAnHeirHearsFirstIsTheOldestThatItTakes) {
    EXPECT_TRUE(a.hear(1));
    b.learn(a.association->progress());
    EXPECT_TRUE(a.hear(2)) << "and dies before it tells";
    EXPECT_TRUE(b.hear(3));
    EXPECT_FALSE(b.hear(2));
}

TEST_F(SpokenBySome, ABrokerWithoutAPlaceOrWithoutAStoredBoundDoesNotSpeak) {
    Broker none{0};
    none.learn(a.association->progress());
    EXPECT_FALSE(none.speak());
    Octets out(100);
    protection::Reserve unstored{0};
    const auto refused =
        a.association->seal(a.cipher, {1, unstored}, ContentType::application_data, message, out);
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error(), Refusal::unstored);
}

TEST_F(SpokenBySome, AfterTheLastTurnNobodySpeaksAndNothingWraps) {
    b.learn({Turn{most_generation << place_bits | 1}, 0});
    EXPECT_FALSE(b.speak());
}

TEST_F(SpokenBySome, NoNumberTwiceThroughCrashesAndPartitionsOfAllKinds) {
    for (std::uint64_t seed = 1; seed <= 30; ++seed) {
        Random random{seed};
        Broker maker{1};
        maker.association.emplace(AssociationId{7}, Path{}, keys);
        std::vector<std::unique_ptr<Broker>> brokers;
        for (std::uint32_t place = 2; place <= 4; ++place) {
            brokers.push_back(std::make_unique<Broker>(place));
            brokers.back()->learn(maker.association->progress());
        }
        std::vector<Broker*> all{&maker};
        for (auto& each : brokers) all.push_back(each.get());
        std::set<std::uint64_t> used;
        for (int step = 0; step < 3'000; ++step) {
            Broker& one = *all[random.below(static_cast<std::uint32_t>(all.size()))];
            Broker& other = *all[random.below(static_cast<std::uint32_t>(all.size()))];
            const auto what = random.below(100);
            if (what < 2) {
                // Back again, it learns what any peer knows: nothing of its own last turns,
                // perhaps.
                one.crash();
                one.learn(&other != &one ? other.association->progress() : Progress{});
            } else if (what < 10 && &one != &other) {
                other.association->on_told(one.association->progress());
            } else if (const auto number = one.speak()) {
                ASSERT_TRUE(used.insert(*number).second) << "seed " << seed << " step " << step;
            }
        }
        EXPECT_GT(used.size(), 1'000U);
    }
}

}  // namespace
}  // namespace romano::dtls::association_test
