#include "overlay/radio/serial_line.h"

#include <gtest/gtest.h>

#include <chrono>

namespace romano::radio::serial_line_test {
namespace {

using namespace std::chrono_literals;
using std::vector;

constexpr std::size_t publish = 39;  // MQTT-SN 7, the paper's payload 32

vector<std::uint8_t> octets(std::size_t count, std::uint8_t value = 'x') {
    return vector<std::uint8_t>(count, value);
}

TEST(SerialLine, AMessageTakes9Point1MsAt115200BaudAndHalfAt230400) {
    EXPECT_EQ(line_time(115'200, ethernet_over_serial, octets(publish)) / 1us, 9'114);
    EXPECT_EQ(line_time(230'400, ethernet_over_serial, octets(publish)) / 1us, 4'557);
    EXPECT_EQ(line_time(115'200, ethernet_over_serial, octets(publish - 12)) / 1us, 8'072);
}

TEST(SerialLine, FlagsAndEscapesInTheDataAreSentAsTwoOctets) {
    const Duration plain = line_time(115'200, robots_hdlc, octets(20));
    EXPECT_EQ(line_time(115'200, robots_hdlc, octets(20, 0x7E)),
              line_time(115'200, robots_hdlc, octets(40)));
    EXPECT_EQ(line_time(115'200, robots_hdlc, octets(20, 0x7D)),
              line_time(115'200, robots_hdlc, octets(40)));
    EXPECT_EQ(line_time(115'200, robots_hdlc, octets(20, 0x7C)), plain);
}

TEST(SerialLine, WhatDoesNotFitOneFrameComesInSeveral) {
    const Duration both = line_time(10'000, robots_hdlc, octets(robots_hdlc.part_max + 1));
    EXPECT_EQ(both / 1ms, 57 + 1 + 2 * 11 + 6);  // ten bits an octet at 10,000 baud: 1 ms
}

TEST(SerialLine, LosesAndCountsWhatItsQueueCannotHold) {
    sim::EventQueue events;
    int delivered = 0;
    SerialLine line(events, 115'200, ethernet_over_serial, 2, [&](const Carried&) {
        ++delivered;
        return true;
    });
    for (int i = 0; i < 5; ++i) (void)line.send({{}, {}, {}, octets(publish)});
    events.run_for(1s);
    EXPECT_EQ(delivered, 2);
    EXPECT_EQ(line.lost(), 3U);
}

TEST(SerialLine, WaitsWhileTheOtherEndHasNoRoom) {
    sim::EventQueue events;
    bool room = false;
    int delivered = 0;
    SerialLine line(events, std::nullopt, ethernet_over_serial, 5, [&](const Carried&) {
        if (room) ++delivered;
        return room;
    });
    (void)line.send({{}, {}, {}, octets(publish)});
    (void)line.send({{}, {}, {}, octets(publish)});
    events.run_for(1s);
    EXPECT_EQ(line.waiting(), 2U);
    room = true;
    line.go_on();
    events.run_for(1s);
    EXPECT_EQ(delivered, 2);
}

}  // namespace
}  // namespace romano::radio::serial_line_test
