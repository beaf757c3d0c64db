// The run against clients that are scripted here: what they lose, double or swap must be told.

#include "experiments/load/load_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "broker/net/clock.h"

namespace romano::experiments::load_run_test {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

/// A perfect network within the process, until `spoil` says otherwise.
class ScriptedClients : public LoadClients {
public:
    explicit ScriptedClients(const LoadPlan& plan) : plan_(plan) {}

    struct Arrival {
        Number client;
        std::vector<std::uint8_t> payload;
    };
    /// Gets the number of the message and what it would deliver.
    std::function<void(std::uint64_t, std::deque<Arrival>&)> spoil;
    std::optional<Number> refused;
    bool has_left = false;

    void attach(Listener& listener) override { listener_ = &listener; }
    void join(Number client) override { joining_.push_back(client); }
    std::optional<PublishId> publish(Instant, Number client, std::uint32_t topic,
                                     Bytes payload) override {
        std::deque<Arrival> arrivals;
        for (Number other = plan_.publishers; other < plan_.clients(); ++other) {
            const auto heard = plan_.heard_by(other);
            if (std::ranges::count(heard, topic) != 0) {
                arrivals.push_back({other, {payload.begin(), payload.end()}});
            }
        }
        if (spoil) spoil(published_, arrivals);
        const auto id = static_cast<PublishId>(published_++);
        if (plan_.qos != Qos::at_most_once) answers_.emplace_back(client, id);
        for (Arrival& arrival : arrivals) on_the_way_.push_back(std::move(arrival));
        return id;
    }
    void turn(Instant) override {
        for (const Number client : std::exchange(joining_, {})) {
            if (client == refused) listener_->on_trouble(client, "no room");
            listener_->on_joined(client);
        }
        for (const auto& [client, id] : std::exchange(answers_, {})) {
            listener_->on_published(net::now(), client, id, true);
        }
        for (const Arrival& arrival : std::exchange(on_the_way_, {})) {
            listener_->on_message(net::now(), arrival.client, arrival.payload, false);
        }
    }
    void leave() override { has_left = true; }
    [[nodiscard]] std::uint64_t retransmissions() const override { return 0; }
    [[nodiscard]] std::uint64_t dropped_here() const override { return 0; }

private:
    const LoadPlan& plan_;
    Listener* listener_ = nullptr;
    std::vector<Number> joining_;
    std::vector<std::pair<Number, PublishId>> answers_;
    std::deque<Arrival> on_the_way_;
    std::uint64_t published_ = 0;
};

LoadPlan brief(LoadPlan plan) {
    plan.warm_up = 0ms;
    plan.duration = 20ms;
    plan.drain = 50ms;
    return plan;
}

LoadFigures run(const LoadPlan& plan, ScriptedClients& clients) {
    LoadRun run{plan, clients, {}};
    return run.run();
}

TEST(LoadRun, ThatCannotBeginLeavesNoSessionBehind) {
    const LoadPlan plan = brief({.publishers = 2, .subscribers = 2});
    ScriptedClients clients{plan};
    clients.refused = 3;
    EXPECT_THROW((void)run(plan, clients), LoadError);
    EXPECT_TRUE(clients.has_left);
}

class LoadRunOverQos : public ::testing::TestWithParam<Qos> {};

TEST_P(LoadRunOverQos, InAPerfectNetworkEverythingArrivesOnceAndInOrder) {
    const LoadPlan plan =
        brief({.publishers = 3, .subscribers = 4, .topics = 2, .qos = GetParam()});
    ScriptedClients clients{plan};
    const LoadFigures figures = run(plan, clients);
    EXPECT_GT(figures.all_published, 64U);
    EXPECT_EQ(figures.expected, 2 * figures.all_published);
    EXPECT_EQ(figures.lost(), 0U);
    EXPECT_EQ(figures.duplicates, 0U);
    EXPECT_EQ(figures.out_of_order, 0U);
    EXPECT_EQ(figures.strays, 0U);
    EXPECT_EQ(figures.unacknowledged, 0U);
    EXPECT_GT(figures.latency.count(), 0U);
}
INSTANTIATE_TEST_SUITE_P(Qos, LoadRunOverQos,
                         ::testing::Values(Qos::at_most_once, Qos::at_least_once,
                                           Qos::exactly_once));

TEST(LoadRun, WhatIsLostDoubledOrStrayIsCounted) {
    const LoadPlan plan = brief({.publishers = 1, .subscribers = 2, .topics = 2});
    ScriptedClients clients{plan};
    clients.spoil = [](std::uint64_t number, std::deque<ScriptedClients::Arrival>& arrivals) {
        if (number == 3) arrivals.clear();
        if (number == 5) arrivals.push_back(arrivals.front());
        if (number == 7)
            arrivals.push_back({arrivals.front().client == 1 ? 2U : 1U, arrivals.front().payload});
    };
    const LoadFigures figures = run(plan, clients);
    EXPECT_EQ(figures.lost(), 1U);
    EXPECT_EQ(figures.duplicates, 1U);
    EXPECT_EQ(figures.strays, 1U);
}

TEST(LoadRun, AMessageHasItsLastSubscriberWhenAllHaveIt) {
    LoadPlan plan = brief({.subscribers = 3});
    plan.rate_per_s = 1000;
    ScriptedClients clients{plan};
    clients.spoil = [](std::uint64_t number, std::deque<ScriptedClients::Arrival>& arrivals) {
        if (number == 3) arrivals.pop_back();
        if (number == 5) arrivals.push_back(arrivals.front());
    };
    const LoadFigures figures = run(plan, clients);
    ASSERT_GT(figures.last_subscriber.count(), 3U);
    EXPECT_EQ(figures.latency.count(), 3 * figures.last_subscriber.count() + 2);
    EXPECT_GE(figures.last_subscriber.mean(), figures.latency.mean());
}

TEST(LoadRun, AtARatePublishesAsManyAsWereDue) {
    LoadPlan plan = brief({});
    plan.rate_per_s = 5000;
    plan.duration = 100ms;
    ScriptedClients clients{plan};
    const Instant began = net::now();
    const LoadFigures figures = run(plan, clients);
    const double took_s = std::chrono::duration<double>(net::now() - began).count();
    EXPECT_GE(figures.all_published, 500U);
    EXPECT_LE(static_cast<double>(figures.all_published), 5000 * took_s + 1);
    EXPECT_EQ(figures.lost(), 0U);
}

TEST(LoadRun, TheClosedLoopGoesOnAfterALoss) {
    LoadPlan plan = brief({.in_flight = 1});
    plan.duration = 1500ms;
    ScriptedClients clients{plan};
    clients.spoil = [](std::uint64_t number, std::deque<ScriptedClients::Arrival>& arrivals) {
        if (number == 0) arrivals.clear();
    };
    const LoadFigures figures = run(plan, clients);
    EXPECT_GT(figures.all_published, 1U);
    EXPECT_EQ(figures.lost(), 1U);
}

}  // namespace
}  // namespace romano::experiments::load_run_test
