#include "firmware/cortex_m3/chip.h"

#include <array>
#include <atomic>

namespace romano::chip {
namespace {

using Register = volatile std::uint32_t;

Register& at(std::uint32_t address) {
    return *reinterpret_cast<Register*>(address);  // NOLINT(performance-no-int-to-ptr): as wired
}

constexpr std::uint32_t rcc = 0x400FE060;    // system clock
constexpr std::uint32_t rcgc1 = 0x400FE104;  // clocks of the UARTs
constexpr std::uint32_t uart0 = 0x4000C000;
constexpr std::uint32_t uart1 = 0x4000D000;
constexpr std::uint32_t systick = 0xE000E010;
constexpr std::uint32_t interrupts_on = 0xE000E100;

// Of a PL011 UART.
constexpr std::uint32_t data = 0x00;
constexpr std::uint32_t flags = 0x18;
constexpr std::uint32_t rx_empty = 1U << 4U;
constexpr std::uint32_t tx_full = 1U << 5U;

constexpr std::uint32_t clock_hz = 50'000'000;
constexpr unsigned uart1_interrupt = 6;

#ifndef ROMANO_CLOCK_STARTS_AT_MS  // a test lets months have passed
#define ROMANO_CLOCK_STARTS_AT_MS 0
#endif
constexpr std::uint64_t start_ms = ROMANO_CLOCK_STARTS_AT_MS;
std::uint32_t volatile milliseconds = start_ms & 0xFFFFFFFFU;
std::uint32_t volatile wraps = start_ms >> 32U;  // of the milliseconds, after 49 days

/// One writer (the interrupt), one reader (the program).
class Ring {
public:
    void put(std::uint8_t octet) {
        const unsigned head = head_;
        if (head - tail_ == octets_.size()) return;  // lost: HDLC repeats it
        octets_[head % octets_.size()] = octet;
        std::atomic_signal_fence(std::memory_order_release);
        head_ = head + 1;
    }
    std::optional<std::uint8_t> get() {
        const unsigned tail = tail_;
        if (head_ == tail) return std::nullopt;
        std::atomic_signal_fence(std::memory_order_acquire);
        const std::uint8_t octet = octets_[tail % octets_.size()];
        tail_ = tail + 1;
        return octet;
    }

private:
    std::array<std::uint8_t, 64> octets_;  // 5 ms at 115200 baud
    unsigned volatile head_;
    unsigned volatile tail_;
};
Ring from_radio;  // all zero at the start

void start_uart(std::uint32_t uart) {
    at(uart + 0x30) = 0;   // off while it is set up
    at(uart + 0x24) = 27;  // 50 MHz / (16 * 115200) = 27 8/64
    at(uart + 0x28) = 8;
    at(uart + 0x2C) = 0x70;  // 8 bits, FIFOs
    at(uart + 0x30) = 0x301;
}

void write(std::uint32_t uart, std::uint8_t octet) {
    while ((at(uart + flags) & tx_full) != 0) {
    }
    at(uart + data) = octet;
}

}  // namespace

void start() {
    at(rcc) = (3U << 23U) | (1U << 22U) | (0xEU << 6U);  // SYSDIV 3, USESYSDIV, 8 MHz crystal
    at(rcgc1) = at(rcgc1) | 3U;
    start_uart(uart0);
    start_uart(uart1);
    at(uart1 + 0x38) = (1U << 4U) | (1U << 6U);  // received, and received a while ago
    at(interrupts_on) = 1U << uart1_interrupt;
    at(systick + 4) = clock_hz / 1000 - 1;
    at(systick + 8) = 0;
    at(systick) = 7;
}

std::uint64_t now_ms() {
    for (;;) {
        const std::uint32_t high = wraps;
        const std::uint32_t low = milliseconds;
        if (high == wraps) return (std::uint64_t{high} << 32U) | low;
    }
}

void restart_clock() {
    milliseconds = 0;
    wraps = 0;
}

void wait() {
    asm volatile("wfi");
}

std::optional<std::uint8_t> read_radio() {
    return from_radio.get();
}

void write_radio(Bytes octets) {
    for (const std::uint8_t octet : octets) write(uart1, octet);
}

void print(std::string_view text) {
    for (const char letter : text) write(uart0, static_cast<std::uint8_t>(letter));
}

extern "C" void on_systick() {
    const std::uint32_t next = milliseconds + 1;
    milliseconds = next;
    if (next == 0) wraps = wraps + 1;
}

extern "C" void on_uart1() {
    at(uart1 + 0x44) = 0x7FF;
    while ((at(uart1 + flags) & rx_empty) == 0) {
        from_radio.put(static_cast<std::uint8_t>(at(uart1 + data)));
    }
}

}  // namespace romano::chip
