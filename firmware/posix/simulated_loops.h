// A simulated robot's loops: its wheels as a plant of one channel, and the simple laws for up to
// four others that it controls.
#pragma once

#include <array>
#include <functional>
#include <optional>
#include <string>

#include "firmware/posix/body.h"
#include "firmware/posix/simple_laws.h"
#include "romano/control/controller.h"
#include "romano/control/plant.h"

namespace romano::firmware {

class SimulatedLoops final : private control::PlantPort, private control::ControllerPort {
public:
    using Publish =
        std::function<void(const control::RomanoId& to, Bytes message, mqttsn::Qos qos)>;
    using Say = std::function<void(const std::string& what)>;

    /// `body` outlives it.
    SimulatedLoops(const control::RomanoId& id, std::uint64_t seed, Body& body, Publish publish,
                   Say say);

    /// A ROMANO message that is_of_a_loop().
    void on_message(Instant now, Bytes message);
    /// Does what is due; true when anything was.
    bool run(Instant now);
    [[nodiscard]] Instant next_wakeup() const;
    /// The body is where it is at that time.
    void move_on(Instant now);

private:
    static constexpr std::size_t places = 4;

    void publish(const control::RomanoId& to, Bytes message, mqttsn::Qos qos) override {
        publish_(to, message, qos);
    }
    std::size_t sense(control::Channel channel, MutableBytes room) override;
    void carry_out(control::Channel channel, Bytes value) override;
    void fall_back(control::Channel channel, control::Fallback fallback) override;
    bool may_open(const control::Open& open) override;
    void on_state(control::Channel channel, control::State state, control::Reason reason) override;

    bool begin(control::Place place, const control::Invite& invite) override;
    std::optional<std::size_t> control(control::Place place, const control::Sample& sample,
                                       MutableBytes room) override;
    void on_end(control::Place place, control::Reason reason) override;

    Body& body_;
    Publish publish_;
    Say say_;
    control::Plant<1> plant_;
    control::Controller<places> controller_;
    std::array<std::optional<Leading>, places> laws_;
    Speed speed_;
    Instant now_{};  // of the call
    Instant moved_at_{};
};

}  // namespace romano::firmware
