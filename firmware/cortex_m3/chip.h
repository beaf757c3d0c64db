// The chip: its two UARTs and its millisecond clock. Texas Instruments LM3S6965, as QEMU has it.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "romano/base/bytes.h"

namespace romano::chip {

/// 50 MHz, UART 0 (console) and UART 1 (radio) at 115200 baud, a tick a millisecond.
void start();
[[nodiscard]] std::uint64_t now_ms();
void restart_clock();
/// Until the next interrupt: a millisecond at most.
void wait();

/// From the radio: an interrupt fills a ring; what comes while it is full is lost and counted.
[[nodiscard]] std::optional<std::uint8_t> read_radio();
void write_radio(Bytes octets);
void print(std::string_view text);

}  // namespace romano::chip
