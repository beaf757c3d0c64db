/* A cart on a rail, and a law that drives it to one metre, both in C: two robots, and
 * `romano control 00000001 00000002 --law 7` makes a loop of them.
 *
 *     loop_c cart 00000001 127.0.0.1 1883
 *     loop_c law 00000002 127.0.0.1 1883
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "firmware/posix/udp_board.h"
#include "firmware/robot/control.h"

static struct romano_loops loops;
static struct romano_udp_board udp;

static uint64_t now_ms(void) {
    return udp.board.now_ms(udp.board.self);
}

/* The cart: its sensor says where it is, its command how fast to drive; i32, mm and mm/s. */

struct cart {
    double position_mm;
    int32_t speed_mm_s;
    uint64_t moved_at_ms;
    bool has_arrived;
};

static void put_i32(uint8_t* out, int32_t value) {
    for (int i = 0; i < 4; ++i) out[i] = (uint8_t)((uint32_t)value >> (24 - 8 * i));
}

static int32_t get_i32(const uint8_t* in) {
    return (int32_t)((uint32_t)in[0] << 24 | (uint32_t)in[1] << 16 | (uint32_t)in[2] << 8 | in[3]);
}

static void say(const char* what) {
    puts(what);
    fflush(stdout);
}

static uint32_t sense(void* self, uint8_t channel, uint8_t* room, uint32_t most) {
    struct cart* cart = self;
    const uint64_t now = now_ms();
    cart->position_mm += cart->speed_mm_s * (double)(now - cart->moved_at_ms) / 1000;
    cart->moved_at_ms = now;
    if (!cart->has_arrived && cart->position_mm > 990) {
        cart->has_arrived = true;
        say("the cart has arrived");
    }
    (void)channel, (void)most;
    put_i32(room, (int32_t)cart->position_mm);
    return 4;
}

static void carry_out(void* self, uint8_t channel, const uint8_t* value, uint32_t size) {
    struct cart* cart = self;
    uint8_t room[4];
    sense(self, channel, room, sizeof room);
    cart->speed_mm_s = size == 4 ? get_i32(value) : 0;
}

static void fall_back(void* self, uint8_t channel, enum romano_fallback fallback) {
    struct cart* cart = self;
    uint8_t room[4];
    sense(self, channel, room, sizeof room);
    if (fallback != ROMANO_HOLD) cart->speed_mm_s = 0;
    say("the cart falls back");
}

/* The law. */

enum { TO_ONE_METRE = 7 };

static bool begin(void* self, uint8_t place, const char plant[9], uint16_t law,
                  const uint8_t* parameters, uint32_t size) {
    (void)self, (void)place, (void)parameters;
    if (law != TO_ONE_METRE || size != 0) return false;
    printf("controls %s\n", plant);
    fflush(stdout);
    return true;
}

static int32_t control(void* self, uint8_t place, const struct romano_sample* sample, uint8_t* room,
                       uint32_t most) {
    (void)self, (void)place, (void)most;
    if (sample->size != 4) return -1;
    put_i32(room, (1000 - get_i32(sample->value)) * 4); /* mm/s: four times what is left, mm */
    return 4;
}

static void on_message(void* self, const char* topic, uint32_t topic_size, const uint8_t* message,
                       uint32_t size) {
    (void)self, (void)topic, (void)topic_size;
    romano_loops_on_message(&loops, now_ms(), message, size);
}

int main(int argc, char** argv) {
    static struct romano_robot robot;
    static struct cart cart;
    static const struct romano_plant plant = {&cart, sense, carry_out, fall_back};
    static const struct romano_law law = {NULL, begin, control, NULL};
    static const struct romano_controller program = {.on_message = on_message};
    struct romano_settings settings = {0};
    struct romano_address local = {0};
    const bool is_cart = argc == 5 && strcmp(argv[1], "cart") == 0;
    const bool is_law = argc == 5 && strcmp(argv[1], "law") == 0;
    if ((!is_cart && !is_law) ||
        !romano_udp_address(argv[3], (uint16_t)atoi(argv[4]), &settings.broker)) {
        fprintf(stderr, "usage: loop_c cart|law ID BROKER-IP PORT\n");
        return 2;
    }
    settings.id = argv[2];
    local.family = settings.broker.family;
    if (romano_udp_open(&udp, &local) != 0) return 1;
    if (!romano_start(&robot, &settings, &udp.board, &program) ||
        !romano_loops_start(&loops, &robot, settings.id, now_ms(), is_cart ? &plant : NULL,
                            is_law ? &law : NULL)) {
        fprintf(stderr, "loop_c: `%s` is no id of 8 lower-case hexadecimal digits\n", argv[2]);
        return 2;
    }
    for (bool was_there = false;;) {
        const uint32_t loops_ms = romano_loops_run(&loops, now_ms());
        const uint32_t ms = romano_run(&robot);
        if (!was_there && romano_is_established(&robot)) say("established");
        was_there = romano_is_established(&robot);
        romano_udp_wait(&udp, loops_ms < ms ? loops_ms : ms);
    }
}
