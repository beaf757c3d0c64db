// From reset to main(): vectors, data, bss. No C library is started; none is needed.

#include <cstdint>

extern "C" {

extern std::uint32_t data_in_flash[];
extern std::uint32_t data_begin[];
extern std::uint32_t data_end[];
extern std::uint32_t bss_begin[];
extern std::uint32_t bss_end[];
extern std::uint32_t stack_top[];

void on_systick();
void on_uart1();
int main();

[[noreturn]] void reset() {
    const std::uint32_t* from = data_in_flash;
    for (std::uint32_t* to = data_begin; to != data_end;) *to++ = *from++;
    for (std::uint32_t* to = bss_begin; to != bss_end;) *to++ = 0;
    (void)main();
    for (;;) {
    }
}

/// A fault is final: the watchdog of a real robot would start it again.
[[noreturn]] void halt() {
    for (;;) {
    }
}

using Handler = void (*)();
struct Vectors {
    std::uint32_t* stack;
    Handler handlers[15 + 7];
};

extern const Vectors vectors;
[[gnu::section(".vectors"), gnu::used]] const Vectors vectors = {
    stack_top,
    {reset,   halt,    halt, halt, halt,    halt, nullptr,    nullptr,
     nullptr, nullptr, halt, halt, nullptr, halt, on_systick,  // the processor's
     halt,    halt,    halt, halt, halt,    halt, on_uart1}};  // the chip's, UART 1 is its 6
}
