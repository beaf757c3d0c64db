// The image that others control: whatever dies of its loop, its wheels stop within the deadline and
// a period. Each is killed twice; with ROMANO_REPEAT=100 in the environment a hundred times.

#include <gmock/gmock.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>

#include "tests/firmware/cortex_m3/qemu_fixture.h"

namespace romano::system::plant_test {
namespace {

using namespace std::chrono_literals;
using Clock = std::chrono::steady_clock;
using Milliseconds = std::chrono::duration<double, std::milli>;

constexpr auto period = 40ms;     // steps of the chip's clock, which are 8 ms
constexpr auto deadline = 800ms;  // a machine that is busy with other tests breaks no loop
constexpr auto busy = 15s;        // what such a machine may take to tell

class PlantOnCortexM3 : public QemuFixture {
protected:
    ~PlantOnCortexM3() override {
        if (kills == 0) return;
        std::printf(
            "%d kills: stopped at most %.0f ms after the last command by the plant's "
            "clock, %.0f ms after the kill by this machine's\n",
            kills, greatest_by_plant_ms, greatest_by_us_ms);
    }

    static int repeats() {
        const char* wanted = std::getenv("ROMANO_REPEAT");
        return wanted == nullptr ? 2 : std::max(1, std::atoi(wanted));
    }

    void start_leader() {
        leader = std::make_unique<Process>(
            ROMANO_ROBOT,
            std::vector<std::string>{"--id", "00000001", "--broker", addresses.service(1)});
        ASSERT_NE(leader->wait_for("established"), "") << leader->errors();
    }
    void start_all() {
        start_broker(1);
        start_broker(2);
        start_leader();
        start_controller({}, PLANT);
        const auto in_ms = [](std::chrono::milliseconds time) {
            return std::to_string(time.count());
        };
        supervisor = std::make_unique<Process>(
            ROMANO_PROGRAM, std::vector<std::string>{
                                "control", "-h", host(1), "-p", "18830", "abcd1234", "00000001",
                                "--law", "go-to", "--to", "1000000,0", "--period-ms", in_ms(period),
                                "--deadline-ms", in_ms(deadline), "--detach"});
        ASSERT_NE(controller->wait_for("plant: turns"), "") << supervisor->errors();
    }
    void stop_all() {
        supervisor.reset();
        radio.reset();
        controller.reset();
        leader.reset();
        brokers.clear();
    }

    /// Kills, and sees the wheels stop and not turn again.
    void expect_stop(const std::function<void()>& kill) {
        const auto killed_at = Clock::now();
        kill();
        std::string line;
        double after_kill_ms = 0;
        do {
            line = controller->wait_for("plant: stops");
            ASSERT_NE(line, "") << "the wheels go on without a controller";
            after_kill_ms = Milliseconds{Clock::now() - killed_at}.count();
        } while (controller->wait_for("plant: turns", deadline + period) != "");
        const double by_plant_ms = std::stod(line.substr(line.find("stops") + 5));
        EXPECT_LE(by_plant_ms, Milliseconds{deadline + period}.count());
        EXPECT_LE(after_kill_ms, Milliseconds{deadline + period + busy}.count());
        greatest_by_plant_ms = std::max(greatest_by_plant_ms, by_plant_ms);
        greatest_by_us_ms = std::max(greatest_by_us_ms, after_kill_ms);
        ++kills;
    }

    std::unique_ptr<Process> leader;
    std::unique_ptr<Process> supervisor;
    int kills = 0;
    double greatest_by_plant_ms = 0;
    double greatest_by_us_ms = 0;
};

TEST_F(PlantOnCortexM3, StopsWhenItsControllerIsKilledAndTurnsForItsSuccessor) {
    start_all();
    for (int i = 0; i < repeats() && !HasFailure(); ++i) {
        if (i > 0) {
            start_leader();
            ASSERT_NE(controller->wait_for("plant: turns"), "");
        }
        expect_stop([this] { leader->kill_9(); });
    }
}

TEST_F(PlantOnCortexM3, StopsWhenItsRadioIsKilled) {
    for (int i = 0; i < repeats() && !HasFailure(); ++i) {
        stop_all();
        start_all();
        if (!HasFailure()) expect_stop([this] { radio->kill_9(); });
    }
}

TEST_F(PlantOnCortexM3, StopsWhenAllBrokersAreKilled) {
    for (int i = 0; i < repeats() && !HasFailure(); ++i) {
        stop_all();
        start_all();
        if (HasFailure()) break;
        expect_stop([this] {
            for (const auto& broker : brokers) broker->kill_9();
        });
    }
}

}  // namespace
}  // namespace romano::system::plant_test
