// A robot that lets others control it and controls others: the shipped client, plant and controller
// cores, on sockets or on a simulated network. What it is beside its network is its device: a body
// with sensor and actuator, or a law.
//
// When its broker says that it does not know it, or answers nothing, it connects anew after a
// second, as romano/node does.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/robots/surroundings.h"
#include "romano/client/client.h"
#include "romano/control/controller.h"
#include "romano/control/plant.h"

namespace romano::experiments {

using control::RomanoId;

class Device {
public:
    virtual ~Device() = default;

    /// As of control::PlantPort.
    virtual std::size_t sense(Instant now, MutableBytes room) {
        (void)now, (void)room;
        return 0;
    }
    virtual void carry_out(Instant now, Bytes value) { (void)now, (void)value; }
    virtual void fall_back(Instant now, control::Fallback fallback) { (void)now, (void)fallback; }
    /// The law: as of control::ControllerPort.
    virtual std::optional<std::size_t> control(Instant now, const RomanoId& plant,
                                               const control::Sample& sample, MutableBytes room) {
        (void)now, (void)plant, (void)sample, (void)room;
        return std::nullopt;
    }
};

struct LoopSettings {
    std::uint16_t period_ms = 20;
    std::uint16_t deadline_ms = 200;
    control::Fallback fallback = control::Fallback::stop;
};

class LoopRobot final : private control::PlantPort, private control::ControllerPort {
public:
    /// The id is `number` in hexadecimal. `surroundings` and `device` outlive it.
    LoopRobot(Surroundings& surroundings, std::uint64_t seed, std::uint32_t number,
              const BrokerAddress& broker, Device& device);
    LoopRobot(const LoopRobot&) = delete;
    LoopRobot& operator=(const LoopRobot&) = delete;

    void start();
    /// Opens a loop between these two, without end: asks the plant each second until it has one.
    void open(const RomanoId& plant, const RomanoId& controller, const LoopSettings& settings);
    /// It is in reach of another broker from now on.
    void roam_to(const BrokerAddress& broker);

    [[nodiscard]] const RomanoId& id() const { return id_; }
    [[nodiscard]] bool is_ready() const { return client_.is_connected() && is_subscribed_; }
    [[nodiscard]] const control::PlantLoop& loop() const { return plant_.loops()[0]; }
    [[nodiscard]] bool is_controlled() const {
        return loop().state() == control::State::controlled;
    }
    /// Since watch(): the greatest age of a command in force, and the longest time from one command
    /// that was carried out to the next.
    [[nodiscard]] Duration greatest_age() const { return greatest_age_; }
    [[nodiscard]] Duration longest_wait() const { return longest_wait_; }
    void watch() { greatest_age_ = longest_wait_ = Duration{0}; }

private:
    static constexpr Duration connect_again{std::chrono::seconds{1}};
    static constexpr Duration ask_again{std::chrono::seconds{1}};
    static constexpr std::size_t places = 8;

    struct Wish {
        RomanoId plant;
        RomanoId controller;
        LoopSettings settings;
    };

    void connect();
    void on_datagram(Bytes datagram);
    void on_event(const client::Event& event);
    void on_report(const control::Report& report);
    void lose_broker();
    void ask();
    void on_timer();
    void rearm();
    void drain();
    void end_of_command();
    template <typename M>
    void say(const RomanoId& to, const M& message);

    void publish(const RomanoId& to, Bytes message, mqttsn::Qos qos) override;
    std::size_t sense(control::Channel channel, MutableBytes room) override;
    void carry_out(control::Channel channel, Bytes value) override;
    void fall_back(control::Channel channel, control::Fallback fallback) override;
    bool begin(control::Place place, const control::Invite& invite) override;
    std::optional<std::size_t> control(control::Place place, const control::Sample& sample,
                                       MutableBytes room) override;

    [[nodiscard]] Instant now() const { return surroundings_.now(); }

    Surroundings& surroundings_;
    RomanoId id_;
    Device& device_;
    client::Client<> client_;
    client::OutputFor<> out_;
    control::Plant<1> plant_;
    control::Controller<places> controller_;
    std::vector<Wish> wishes_;  // of loops that their plants do not have yet
    std::optional<client::OperationId> subscription_;
    bool is_subscribed_ = false;
    Instant connect_at_ = never;
    Instant ask_at_ = never;
    std::optional<Instant> sampled_at_;  // of the command in force
    Instant carried_out_at_{};
    Duration greatest_age_{0};
    Duration longest_wait_{0};
    std::unique_ptr<Alarm> alarm_;
    std::unique_ptr<Port> port_;
};

/// 1: "00000001".
[[nodiscard]] RomanoId id_of_robot(std::uint32_t number);

}  // namespace romano::experiments
