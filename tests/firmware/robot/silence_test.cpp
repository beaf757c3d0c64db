// Robots that only publish at QoS 0 get no answers: how they notice that a broker is far away.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <deque>
#include <optional>
#include <variant>
#include <vector>

#include "firmware/robot/address.h"
#include "firmware/robot/robot.h"
#include "romano/mqttsn/codec.h"

namespace romano::firmware::silence_test {
namespace {

using namespace std::chrono_literals;

constexpr double weakest_dbm = -85;

Endpoint endpoint(std::size_t broker) {
    return {.address = {10, 0, 0, static_cast<std::uint8_t>(broker + 1)},
            .port = 1883,
            .family = Endpoint::Family::ipv4};
}

/// A robot on a line, and brokers of one cluster that stand beside it: each answers whatever it
/// hears as if it had the session.
class Line {
public:
    explicit Line(std::vector<double> brokers) : brokers_(std::move(brokers)) {
        board_.self = this;
        board_.now_ms = [](void* self) { return static_cast<Line*>(self)->now_ms_; };
        board_.send = [](void* self, const romano_address* to, const std::uint8_t* octets,
                         std::uint32_t size) {
            static_cast<Line*>(self)->send(*to, {octets, size});
        };
        board_.receive = [](void* self, romano_address* from, std::uint32_t* size) {
            return static_cast<Line*>(self)->receive(*from, *size);
        };
        board_.link_dbm = [](void* self, const romano_address* peer) {
            return static_cast<Line*>(self)->dbm_as_heard(*peer);
        };
        RobotSettings settings;
        settings.timing.t_retry = 1s;
        robot_.emplace(settings, board_, controller_);
    }

    /// Publishes 20 messages a second at QoS 0 meanwhile.
    void drive(double metres_a_second, std::chrono::milliseconds time) {
        for (const std::uint64_t end = now_ms_ + static_cast<std::uint64_t>(time.count());
             now_ms_ < end; ++now_ms_) {
            place_ += metres_a_second / 1000;
            (void)robot_->run();
            if (now_ms_ % 50 != 0 || !robot_->broker()) continue;
            const bool taken = robot_->publish("pose", message::NormalData{}, mqttsn::Qos{});
            published_ += taken ? 1 : 0;
        }
    }
    void switch_off(std::size_t broker) { brokers_[broker] = 1e6; }

    [[nodiscard]] int lost() const { return published_ - arrived_; }
    [[nodiscard]] int pings() const { return pings_; }
    [[nodiscard]] const Robot<>& robot() const { return *robot_; }

private:
    struct Datagram {
        std::size_t broker;
        std::vector<std::uint8_t> octets;
    };

    [[nodiscard]] double dbm(std::size_t broker) const {
        return -40 - 30 * std::log10(std::max(1.0, std::abs(brokers_[broker] - place_)));
    }
    [[nodiscard]] int dbm_as_heard(const romano_address& peer) const {
        return static_cast<int>(dbm(peer.ip[3] - 1U));
    }
    void send(const romano_address& to, Bytes octets) {
        for (std::size_t i = 0; i < brokers_.size(); ++i) {
            const bool is_meant = to.family == 0 || endpoint_of(to) == endpoint(i);
            if (is_meant && dbm(i) >= weakest_dbm) hear(i, mqttsn::decode(octets).value());
        }
    }
    void hear(std::size_t broker, const mqttsn::Message& message) {
        using namespace mqttsn;
        if (std::holds_alternative<Searchgw>(message)) {
            answer(broker, Gwinfo{static_cast<std::uint8_t>(broker + 1), {}});
        } else if (std::holds_alternative<Connect>(message)) {
            answer(broker, Connack{ReturnCode::accepted});
        } else if (std::holds_alternative<Pingreq>(message)) {
            ++pings_;
            answer(broker, Pingresp{});
        } else if (const auto* subscribe = std::get_if<Subscribe>(&message)) {
            answer(broker, Suback{subscribe->qos, TopicId{1}, subscribe->msg_id, {}});
        } else if (const auto* asked = std::get_if<Register>(&message)) {
            const TopicId id{static_cast<std::uint16_t>(1 + asked->topic_name.size())};
            answer(broker, Regack{id, asked->msg_id, {}});
        } else if (const auto* publish = std::get_if<Publish>(&message)) {
            if (publish->qos == Qos::at_most_once) {
                ++arrived_;
            } else {
                answer(broker, Puback{publish->topic, publish->msg_id, {}});
                const std::array<std::uint8_t, 2> ack{0x0C, 2};  // CONNECTION_ACK
                Publish connection_ack{};
                connection_ack.topic = TopicId{1};
                connection_ack.data = ack;
                answer(broker, connection_ack);
            }
        }
    }
    void answer(std::size_t broker, const mqttsn::Message& message) {
        std::vector<std::uint8_t> octets(mqttsn::encoded_size(message));
        ASSERT_EQ(mqttsn::encode(message, octets), octets.size());
        to_robot_.push_back({broker, octets});
    }
    const std::uint8_t* receive(romano_address& from, std::uint32_t& size) {
        if (to_robot_.empty()) return nullptr;
        received_ = to_robot_.front();
        to_robot_.pop_front();
        from = address_of(endpoint(received_.broker));
        size = static_cast<std::uint32_t>(received_.octets.size());
        return received_.octets.data();
    }

    std::vector<double> brokers_;  // where they stand, metres
    double place_ = 3;
    std::uint64_t now_ms_ = 1000;
    romano_board board_{};
    std::deque<Datagram> to_robot_;
    Datagram received_{};
    int published_ = 0;
    int arrived_ = 0;
    int pings_ = 0;
    struct Nobody final : Controller {};
    Nobody controller_;
    std::optional<Robot<>> robot_;
};

TEST(Silence, OfABrokerAtQos0CostsNoMessagesBetweenCells) {
    Line line{{0, 36}};
    line.drive(0, 3s);
    for (int lap = 0; lap < 5; ++lap) {
        line.drive(3, 10s);
        EXPECT_EQ(line.robot().broker(), endpoint(1)) << lap;
        line.drive(-3, 10s);
        EXPECT_EQ(line.robot().broker(), endpoint(0)) << lap;
    }
    EXPECT_LE(line.lost(), 2 * 10) << "in ten moves at 20 messages a second";
}

TEST(Silence, OfABrokerThatIsTalkedToIsEndedByAPingEveryHalfSecond) {
    Line line{{0}};
    line.drive(0, 3s);
    const int before = line.pings();
    line.drive(0, 10s);
    EXPECT_GE(line.pings() - before, 15);
    EXPECT_LE(line.pings() - before, 20);
    EXPECT_EQ(line.lost(), 0);
}

TEST(Silence, OfABrokerThatAnswersNoPingMakesTheRobotTakeAnother) {
    Line line{{0, 15}};
    line.drive(0, 3s);
    ASSERT_EQ(line.robot().broker(), endpoint(0));
    line.switch_off(0);
    line.drive(0, 3s);
    EXPECT_EQ(line.robot().broker(), endpoint(1));
    EXPECT_LE(line.lost(), 30) << "a second and a half";
    EXPECT_EQ(line.robot().node().counters().connections_lost, 0U) << "the session went along";
}

TEST(Silence, OfTheOnlyBrokerIsWaitedOut) {
    Line line{{0}};
    line.drive(0, 3s);
    line.drive(10, 3s);
    line.drive(-10, 3s);
    EXPECT_EQ(line.robot().broker(), endpoint(0));
    const int lost = line.lost();
    line.drive(0, 3s);
    EXPECT_EQ(line.lost(), lost);
}

}  // namespace
}  // namespace romano::firmware::silence_test
