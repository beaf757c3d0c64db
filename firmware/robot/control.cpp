#include "firmware/robot/control.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <new>

#include "romano/control/controller.h"
#include "romano/control/plant.h"

namespace {

using namespace romano;
using namespace std::chrono_literals;

struct IdInC {
    explicit IdInC(const message::RomanoId& id) {
        std::ranges::copy(id.text(), text.begin());
        text.back() = '\0';
    }
    std::array<char, message::RomanoId::size + 1> text;
};

std::uint32_t size_of(Bytes octets) {
    return static_cast<std::uint32_t>(octets.size());
}

class LoopsForC final : private control::PlantPort, private control::ControllerPort {
public:
    LoopsForC(romano_robot* robot, const message::RomanoId& id, std::uint64_t seed,
              const romano_plant* plant, const romano_law* law)
        : robot_(robot),
          actuator_(plant),
          law_(law),
          plant_({.id = id, .seed = seed}),
          controller_(id) {}

    void on_message(Instant now, Bytes message) {
        if (actuator_ != nullptr) plant_.on_message(now, message, *this);
        if (law_ != nullptr) controller_.on_message(now, message, *this);
    }
    Instant run(Instant now) {
        plant_.on_tick(now, *this);
        controller_.on_tick(now, *this);
        return std::min(plant_.next_wakeup(), controller_.next_wakeup());
    }

private:
    void publish(const control::RomanoId& to, Bytes message, mqttsn::Qos qos) override {
        constexpr std::size_t header = 2;
        const Bytes data = message.subspan(header);
        (void)romano_publish(robot_, IdInC{to}.text.data(), control::data_type, data.data(),
                             size_of(data), static_cast<int>(qos));
    }
    std::size_t sense(control::Channel channel, MutableBytes room) override {
        return actuator_->sense(actuator_->self, number(channel), room.data(), size_of(room));
    }
    void carry_out(control::Channel channel, Bytes value) override {
        actuator_->carry_out(actuator_->self, number(channel), value.data(), size_of(value));
    }
    void fall_back(control::Channel channel, control::Fallback fallback) override {
        actuator_->fall_back(actuator_->self, number(channel),
                             static_cast<romano_fallback>(fallback));
    }
    bool begin(control::Place place, const control::Invite& invite) override {
        return law_->begin(law_->self, number(place), IdInC{invite.plant}.text.data(),
                           static_cast<std::uint16_t>(invite.law), invite.parameters.data(),
                           size_of(invite.parameters));
    }
    std::optional<std::size_t> control(control::Place place, const control::Sample& sample,
                                       MutableBytes room) override {
        const romano_sample in_c{sample.sequence, sample.tick, sample.age, sample.value.data(),
                                 size_of(sample.value)};
        const std::int32_t size =
            law_->control(law_->self, number(place), &in_c, room.data(), size_of(room));
        if (size < 0) return std::nullopt;
        return static_cast<std::size_t>(size);
    }
    void on_end(control::Place place, control::Reason) override {
        if (law_->end != nullptr) law_->end(law_->self, number(place));
    }
    template <typename Enum>
    static std::uint8_t number(Enum value) {
        return static_cast<std::uint8_t>(value);
    }

    romano_robot* robot_;
    const romano_plant* actuator_;
    const romano_law* law_;
    control::Plant<ROMANO_PLANT_CHANNELS> plant_;
    control::Controller<ROMANO_LAW_PLACES> controller_;
};
static_assert(sizeof(LoopsForC) <= sizeof(romano_loops));
static_assert(alignof(LoopsForC) <= alignof(romano_loops));

LoopsForC& loops_of(romano_loops* loops) {
    return *std::launder(reinterpret_cast<LoopsForC*>(loops->storage));
}

Instant instant(std::uint64_t ms) {
    return Instant{to_duration(std::chrono::milliseconds{ms})};
}

}  // namespace

bool romano_loops_start(romano_loops* loops, romano_robot* robot, const char* id,
                        std::uint64_t seed, const romano_plant* plant, const romano_law* law) {
    const auto parsed = message::RomanoId::parse(id);
    if (!parsed) return false;
    new (loops->storage) LoopsForC(robot, *parsed, seed, plant, law);
    return true;
}

bool romano_loops_on_message(romano_loops* loops, std::uint64_t now_ms, const std::uint8_t* message,
                             std::uint32_t size) {
    const Bytes octets{message, size};
    if (!control::is_of_a_loop(octets)) return false;
    loops_of(loops).on_message(instant(now_ms), octets);
    return true;
}

std::uint32_t romano_loops_run(romano_loops* loops, std::uint64_t now_ms) {
    const Instant now = instant(now_ms);
    const Instant due = std::min(loops_of(loops).run(now), now + 10s);
    if (due <= now) return 0;
    return static_cast<std::uint32_t>(
        std::chrono::ceil<std::chrono::milliseconds>(due - now).count());
}
