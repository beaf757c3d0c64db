// A robot that others control (romano/control), on the same chip: wheels on a rail, channel 0.
//
// Its sensor says where it is as a ROMANO location, x alone; a command is a ROMANO speed. It prints
// to the console when its wheels begin to turn, and when they stop for want of a command: how long
// after the last one, by its own clock.

#include "romano/control/plant.h"

#include "firmware/cortex_m3/line_robot.h"

namespace {

using namespace romano;

class Wheels final : public chip::LineRobot, private control::PlantPort {
    using Plant = control::Plant<1>;

    // --- the robot

    void on_start(const message::RomanoId& id, std::uint64_t seed) override {
        if (plant_ != nullptr) stop();  // its clock begins anew, and knows nothing of the loop
        plant_ = new (storage_) Plant({.id = id, .seed = seed});
    }
    void on_message(std::string_view, Bytes message) override {
        if (control::is_of_a_loop(message)) plant_->on_message(now(), message, *this);
    }
    void work(Robot&) override {
        if (plant_->next_wakeup() <= now()) plant_->on_tick(now(), *this);
    }

    // --- the plant

    void publish(const control::RomanoId& to, Bytes message, mqttsn::Qos qos) override {
        constexpr std::size_t header = 2;
        (void)robot().publish(
            to.text(), message::ApplicationData{control::data_type, message.subspan(header)}, qos);
    }

    std::size_t sense(control::Channel, MutableBytes room) override {
        move_on();
        constexpr std::size_t location = 12;
        for (std::size_t i = 0; i < location; ++i) room[i] = 0;  // neither y nor heading
        const auto x = static_cast<std::uint32_t>(mm_);
        put_be16(room, 0, static_cast<std::uint16_t>(x >> 16U));
        put_be16(room, 2, static_cast<std::uint16_t>(x & 0xFFFFU));
        return location;
    }

    void carry_out(control::Channel, Bytes value) override {
        move_on();
        constexpr std::size_t speed = 8;
        mm_s_ =
            value.size() != speed
                ? 0
                : static_cast<std::int32_t>(std::uint32_t{be16(value, 0)} << 16U | be16(value, 2));
        carried_out_ms_ = chip::now_ms();
        if (!is_controlled_) chip::print("plant: turns\r\n");
        is_controlled_ = true;
    }

    /// As fast as these wheels can.
    static std::int32_t speed_in(Bytes value) {
        constexpr std::int32_t most = 1'000;
        const auto mm_s =
            static_cast<std::int32_t>(std::uint32_t{be16(value, 0)} << 16U | be16(value, 2));
        return mm_s > most ? most : mm_s < -most ? -most : mm_s;
    }

    void fall_back(control::Channel, control::Fallback fallback) override {
        if (fallback != control::Fallback::hold) stop();
    }

    void stop() {
        move_on();
        mm_s_ = 0;
        if (!is_controlled_) return;
        is_controlled_ = false;
        chip::print("plant: stops ");
        print_number(static_cast<std::uint32_t>(chip::now_ms() - carried_out_ms_));
        chip::print(" ms after its last command\r\n");
    }

    void move_on() {
        const std::uint64_t at_ms = chip::now_ms();
        micrometres_ += mm_s_ * static_cast<std::int32_t>(at_ms - moved_at_ms_);
        mm_ += micrometres_ / 1000;
        micrometres_ %= 1000;
        moved_at_ms_ = at_ms;
    }

    bool is_controlled_ = false;
    std::int32_t mm_s_ = 0;
    std::int32_t mm_ = 0;
    std::int32_t micrometres_ = 0;  // beyond them
    std::uint64_t moved_at_ms_ = 0;
    std::uint64_t carried_out_ms_ = 0;
    Plant* plant_ = nullptr;
    alignas(Plant) std::uint8_t storage_[sizeof(Plant)];
};

alignas(Wheels) std::uint8_t storage[sizeof(Wheels)];

}  // namespace

int main() {
    (new (storage) Wheels)->run();
    return 0;
}
