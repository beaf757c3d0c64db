// No nonce twice under one key, and no packet accepted twice, while robot and brokers crash at any
// point, storing included, and both brokers speak to the robot at once.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "romano/base/random.h"
#include "tests/romano/protection/cell.h"

namespace romano::protection {
namespace {

/// Flash or a file: it outlives the process.
struct Stored {
    std::uint32_t robots_bound = 0;
    struct OfBroker {
        SenderId identity{};
        std::uint32_t bound = 0;
        std::optional<Heard> heard;
    };
    std::array<OfBroker, 2> brokers;
};

class World {
public:
    explicit World(std::uint64_t seed) : random_(seed) {
        for (std::size_t i = 0; i < 2; ++i) draw_identity(i);
        start_robot();
        start_broker(0);
        start_broker(1);
    }

    void step() {
        const std::size_t which = random_.below(2);
        switch (random_.below(100)) {
            case 0:
                return start_robot();
            case 1:
                return start_broker(which);
            case 2:
                return lose_everything(which);
            case 3:
                return robot_->skip_block();
            case 4:
                return end_orderly(which);
            default:
                break;
        }
        switch (random_.below(4)) {
            case 0:
                return robot_sends();
            case 1:
                return broker_sends(which);
            case 2:
                return arrive_at_robot();
            default:
                return arrive_at_broker(which);
        }
    }

    [[nodiscard]] std::size_t sealed() const { return nonces_.size(); }
    [[nodiscard]] std::size_t accepted() const { return accepted_; }

private:
    enum class Direction : std::uint8_t { to_broker, to_robot };

    struct RunningBroker {
        explicit RunningBroker(const Stored::OfBroker& stored)
            : reserve(stored.bound),
              end(robots_keys, robots_name, stored.identity, reserve, stored.heard) {}
        Reserve reserve;
        BrokerEnd end;
    };

    void draw_identity(std::size_t i) {
        for (std::uint8_t& octet : stored_.brokers[i].identity) {
            octet = static_cast<std::uint8_t>(random_.next() >> 24U);
        }
    }
    void start_robot() {
        robot_ = std::make_unique<RobotEnd>(robots_keys, robots_name, stored_.robots_bound);
    }
    void start_broker(std::size_t i) {
        brokers_[i] = std::make_unique<RunningBroker>(stored_.brokers[i]);
    }
    /// A new disk: the broker is another one to its robots.
    void lose_everything(std::size_t i) {
        stored_.brokers[i] = {};
        draw_identity(i);
        taken_by_broker_[i].clear();
        start_broker(i);
    }
    void end_orderly(std::size_t i) {
        if (const auto heard = brokers_[i]->end.heard()) stored_.brokers[i].heard = heard;
        start_broker(i);
    }

    /// Storing may end in a crash, before or after the bound is there. False then.
    bool store_robots() {
        const auto bound = robot_->reserve().to_store();
        if (!bound) return true;
        const std::uint32_t luck = random_.below(10);
        if (luck <= 1) {
            if (luck == 1) stored_.robots_bound = *bound;
            start_robot();
            return false;
        }
        if (luck <= 4) return true;  // it takes longer, and the robot goes on meanwhile
        stored_.robots_bound = *bound;
        robot_->reserve().on_stored(*bound);
        return true;
    }
    bool store_brokers(std::size_t i) {
        const auto bound = brokers_[i]->reserve.to_store();
        if (!bound) return true;
        const std::uint32_t luck = random_.below(10);
        if (luck <= 1) {
            if (luck == 1) stored_.brokers[i].bound = *bound;
            start_broker(i);
            return false;
        }
        if (luck <= 4) return true;
        stored_.brokers[i].bound = *bound;
        brokers_[i]->reserve.on_stored(*bound);
        return true;
    }

    void note(Direction direction, Octets packet) {
        const auto parsed = parse(packet);
        ASSERT_TRUE(parsed);
        ASSERT_TRUE(nonces_.insert({direction, nonce_of(parsed->header)}).second)
            << "a nonce twice: " << hex(parsed->header);
    }
    void robot_sends() {
        if (!store_robots()) return;
        const std::uint32_t many = random_.below(200) == 0 ? numbers_a_block : 1;
        for (std::uint32_t i = 0; i < many; ++i) {
            Octets packet(40);
            packet.resize(robot_->seal(pingreq, packet));
            if (packet.empty()) return;
            note(Direction::to_broker, packet);
            to_broker_.push_back(packet);
        }
    }
    void broker_sends(std::size_t which) {
        if (!store_brokers(which)) return;
        const std::uint32_t many = random_.below(200) == 0 ? numbers_a_block : 1;
        for (std::uint32_t i = 0; i < many; ++i) {
            Octets packet(40);
            packet.resize(brokers_[which]->end.seal(pingresp, packet));
            if (packet.empty()) return;
            note(Direction::to_robot, packet);
            to_robot_.push_back(packet);
        }
    }

    /// One of the last packets, or any that was ever sent: late, repeated, or recorded and played
    /// back.
    const Octets* any_of(const std::vector<Octets>& packets) {
        if (packets.empty()) return nullptr;
        const auto size = static_cast<std::uint32_t>(packets.size());
        const bool is_recent = random_.below(2) == 0;
        const std::uint32_t age = random_.below(is_recent ? std::min(size, 8U) : size);
        return &packets[size - 1 - age];
    }
    void arrive_at_robot() {
        const Octets* packet = any_of(to_robot_);
        if (packet == nullptr) return;
        Octets datagram = *packet;
        if (robot_->open(datagram).empty()) return;
        ++accepted_;
        ASSERT_TRUE(taken_by_robot_.insert(*packet).second) << "taken twice: " << hex(*packet);
    }
    void arrive_at_broker(std::size_t which) {
        const Octets* packet = any_of(to_broker_);
        if (packet == nullptr) return;
        Octets datagram = *packet;
        if (brokers_[which]->end.open(datagram).empty()) return;
        if (const auto heard = brokers_[which]->end.to_store()) {
            if (random_.below(10) == 0) return start_broker(which);  // before it had an effect
            stored_.brokers[which].heard = heard;
            brokers_[which]->end.on_stored(*heard);
        }
        ++accepted_;
        ASSERT_TRUE(taken_by_broker_[which].insert(*packet).second)
            << "taken twice: " << hex(*packet);
    }

    Random random_;
    Stored stored_;
    std::unique_ptr<RobotEnd> robot_;
    std::array<std::unique_ptr<RunningBroker>, 2> brokers_;
    std::vector<Octets> to_broker_;
    std::vector<Octets> to_robot_;
    std::set<std::pair<Direction, Nonce>> nonces_;
    std::set<Octets> taken_by_robot_;
    std::array<std::set<Octets>, 2> taken_by_broker_;
    std::size_t accepted_ = 0;
};

TEST(Crashes, RepeatNoNonceAndNoPacketWhicheverBrokersSpeakToTheRobot) {
    std::size_t sealed = 0;
    std::size_t accepted = 0;
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
        SCOPED_TRACE("seed " + std::to_string(seed));
        World world{seed};
        for (int i = 0; i < 2'000 && !testing::Test::HasFailure(); ++i) world.step();
        sealed += world.sealed();
        accepted += world.accepted();
    }
    EXPECT_GT(sealed, 100'000u);  // the worlds were not idle
    EXPECT_GT(accepted, 3'000u);
}

}  // namespace
}  // namespace romano::protection
