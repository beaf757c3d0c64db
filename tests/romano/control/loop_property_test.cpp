// Loops over a network that loses, doubles, delays, reorders, replays, cuts and garbles messages,
// with ends that stall and start anew, by seed. The rule holds all the time, and control comes back
// when the faults are over.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "romano/base/random.h"
#include "tests/romano/control/ends.h"

namespace romano::control::loop_property_test {
namespace {

using namespace std::chrono_literals;

constexpr Duration step = 1ms;
constexpr Duration deadline = 100ms;

/// The truth behind a command, which travels in its value and is not garbled.
struct Truth {
    std::int64_t taken_at;
    std::uint32_t number;  // of the sample, over all loops of the world
};

class World {
public:
    explicit World(std::uint64_t seed) : random_(seed), plant_end_(*this), controller_end_(*this) {
        start_plant();
        start_controller();
    }

    void run_for(Duration time, bool with_faults) {
        has_faults_ = with_faults;
        for (const Instant until = now_ + time; now_ < until; now_ += step) turn();
    }

    [[nodiscard]] State state() const { return plant_->loops()[0].state(); }
    [[nodiscard]] std::uint64_t carried_out() const { return carried_out_; }
    [[nodiscard]] std::uint64_t falls() const { return falls_; }
    [[nodiscard]] std::uint64_t openings() const { return openings_; }

private:
    struct PlantPost final : PlantPort {
        explicit PlantPost(World& w) : world(w) {}
        void publish(const RomanoId& to, Bytes message, mqttsn::Qos) override {
            world.post(to, message);
        }
        std::size_t sense(Channel, MutableBytes room) override { return world.sense(room); }
        void carry_out(Channel, Bytes value) override { world.carry_out(value); }
        void fall_back(Channel, Fallback) override { world.fall_back(); }
        void on_state(Channel, State state, Reason) override { world.on_state(state); }
        World& world;
    };
    struct ControllerPost final : ControllerPort {
        explicit ControllerPost(World& w) : world(w) {}
        void publish(const RomanoId& to, Bytes message, mqttsn::Qos) override {
            world.post(to, message);
        }
        bool begin(Place, const Invite&) override { return true; }
        std::optional<std::size_t> control(Place, const Sample& sample,
                                           MutableBytes room) override {
            std::copy(sample.value.begin(), sample.value.end(), room.begin());
            return sample.value.size();
        }
        World& world;
    };

    void turn() {
        operate();
        deliver();
        if (has_faults_ && random_.happens(2'000)) plant_stalls_until_ = now_ + stall();
        if (has_faults_ && random_.happens(2'000)) controller_stalls_until_ = now_ + stall();
        if (has_faults_ && random_.happens(300)) start_controller();
        if (has_faults_ && random_.happens(100)) start_plant();
        if (plant_stalls_until_ <= now_) plant_->on_tick(now_, plant_end_);
        check();
        if (controller_stalls_until_ <= now_) controller_->on_tick(now_, controller_end_);
    }

    /// Whoever opens loops: asks, opens with the ticket, and now and then ends one.
    void operate() {
        if (now_ < operates_at_) return;
        operates_at_ = now_ + 500ms;
        if (has_faults_ && random_.happens(100'000)) {
            say(End{session_, operator_id});
        } else {
            say(Ask{Channel{0}, operator_id});
        }
    }
    void on_report(const Report& report) {
        session_ = report.session;
        if (report.state == State::free && report.reason == Reason::none) {
            say(open_with(report.session));
        }
    }
    template <typename M>
    void say(const M& message) {
        post(plant_id, octets_of(message));
    }

    void post(const RomanoId& to, Bytes message) {
        const Octets octets{message.begin(), message.end()};
        captured_.push_back({to, octets});
        if (captured_.size() > 2'000) captured_.erase(captured_.begin());
        send_on(to, octets);
        if (!has_faults_) return;
        if (random_.happens(100'000)) send_on(to, octets);
        if (random_.happens(100'000)) {
            const auto& old =
                captured_[random_.below(static_cast<std::uint32_t>(captured_.size()))];
            send_on(old.first, old.second);
        }
        if (random_.happens(50'000)) send_on(to, random_octets());
    }
    void send_on(const RomanoId& to, Octets octets) {
        Duration delay = 2ms;
        if (has_faults_) {
            if (random_.happens(150'000)) return;  // lost
            delay = random_.between(0ms, random_.happens(100'000) ? 300ms : 30ms);
            if (random_.happens(50'000)) garble(octets);
            if (random_.happens(20'000)) octets.resize(random_.below(30));
        }
        in_flight_.emplace(now_ + delay, std::pair{to, octets});
    }
    /// Not what is the application's, and not the settings of a loop.
    void garble(Octets& octets) {
        if (octets.size() < 7 || octets[2] == 2) return;
        const std::uint32_t end = octets[2] == 9 ? 15 : 17;
        const std::uint32_t at =
            random_.below(std::min(end, static_cast<std::uint32_t>(octets.size())));
        octets[at] = static_cast<std::uint8_t>(octets[at] ^ (1U << random_.below(8)));
        if (octets[2] == 2) octets[2] = 1;
    }
    Octets random_octets() {
        Octets octets(3 + random_.below(60));
        for (auto& octet : octets) octet = static_cast<std::uint8_t>(random_.next());
        octets[0] = data_type;
        octets[1] = static_cast<std::uint8_t>(octets.size());
        octets[2] = static_cast<std::uint8_t>(3 + random_.below(9));
        return octets;
    }

    void deliver() {
        while (!in_flight_.empty() && in_flight_.begin()->first <= now_) {
            const auto [to, octets] = in_flight_.begin()->second;
            in_flight_.erase(in_flight_.begin());
            if (to == operator_id) {
                const auto message = decode(octets);
                const auto* report = message ? std::get_if<Report>(&*message) : nullptr;
                if (report != nullptr) on_report(*report);
            } else if (to == plant_id) {  // a stalled end reads it afterwards
                if (plant_stalls_until_ > now_) {
                    in_flight_.emplace(plant_stalls_until_, std::pair{to, octets});
                } else {
                    plant_->on_message(now_, octets, plant_end_);
                }
            } else if (to == controller_id) {
                if (controller_stalls_until_ > now_) {
                    in_flight_.emplace(controller_stalls_until_, std::pair{to, octets});
                } else {
                    controller_->on_message(now_, octets, controller_end_);
                }
            }
        }
    }

    // What the plant does, and the rule.

    std::size_t sense(MutableBytes room) {
        const Truth truth{now_.time_since_epoch().count(), ++numbers_};
        std::memcpy(room.data(), &truth, sizeof truth);
        return sizeof truth;
    }
    void carry_out(Bytes value) {
        ASSERT_EQ(value.size(), sizeof(Truth));
        Truth truth{};
        std::memcpy(&truth, value.data(), sizeof truth);
        const Instant taken_at{Duration{truth.taken_at}};
        ASSERT_LT(now_ - taken_at, deadline) << "too old";
        ASSERT_GT(truth.number, last_number_) << "twice, or out of order";
        last_number_ = truth.number;
        in_force_ = taken_at;
        ++carried_out_;
    }
    void fall_back() {
        ASSERT_TRUE(in_force_ || is_opening_) << "fell back twice";
        in_force_.reset();
        is_opening_ = false;
        ++falls_;
    }
    void on_state(State state) {
        if (state == State::free) is_opening_ = true;
        if (state == State::inviting) ++openings_;
    }
    void check() {
        const bool is_controlled = plant_->loops()[0].state() == State::controlled;
        ASSERT_EQ(is_controlled, in_force_.has_value());
        if (in_force_ && plant_stalls_until_ <= now_) {
            ASSERT_LT(now_ - *in_force_, deadline) << "in force";
        }
    }
    void start_plant() {
        plant_ = std::make_unique<Plant<1>>(PlantOptions{.id = plant_id, .seed = 1});
        in_force_.reset();  // a body that starts stands still
        is_opening_ = true;
        plant_stalls_until_ = now_ + 5ms;
    }
    void start_controller() { controller_ = std::make_unique<Controller<2>>(controller_id); }
    Duration stall() { return random_.between(1ms, 400ms); }

    Random random_;
    Instant now_{1h};
    bool has_faults_ = true;
    PlantPost plant_end_;
    ControllerPost controller_end_;
    std::unique_ptr<Plant<1>> plant_;
    std::unique_ptr<Controller<2>> controller_;
    std::multimap<Instant, std::pair<RomanoId, Octets>> in_flight_;
    std::vector<std::pair<RomanoId, Octets>> captured_;
    Instant plant_stalls_until_{};
    Instant controller_stalls_until_{};
    Instant operates_at_{};
    Session session_{};

    std::uint32_t numbers_ = 0;
    std::uint32_t last_number_ = 0;
    std::optional<Instant> in_force_;
    bool is_opening_ = true;
    std::uint64_t carried_out_ = 0;
    std::uint64_t falls_ = 0;
    std::uint64_t openings_ = 0;
};

struct LoopProperty : testing::TestWithParam<std::uint64_t> {};

TEST_P(LoopProperty, TheRuleHoldsAndControlComesBack) {
    World world{GetParam()};
    world.run_for(30s, true);
    if (HasFatalFailure()) return;
    const std::uint64_t before = world.carried_out();
    EXPECT_GT(before, 20U);
    EXPECT_GT(world.falls(), 3U);
    world.run_for(7s, false);
    if (HasFatalFailure()) return;
    EXPECT_EQ(world.state(), State::controlled);
    const std::uint64_t falls = world.falls();
    const std::uint64_t carried_out = world.carried_out();
    world.run_for(5s, false);
    EXPECT_EQ(world.falls(), falls);
    EXPECT_EQ(world.carried_out(), carried_out + 250);
}

INSTANTIATE_TEST_SUITE_P(Seeds, LoopProperty, testing::Range<std::uint64_t>(1, 101));

}  // namespace
}  // namespace romano::control::loop_property_test
