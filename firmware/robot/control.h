/* Loops between robots for programs in C: a robot that lets others control it, and one whose law
 * controls others. What happens and when is specified in romano/control/README.md.
 *
 *     static struct romano_loops loops;
 *     struct romano_controller program = {.on_message = on_message};
 *     romano_start(&robot, &settings, &board, &program);
 *     romano_loops_start(&loops, &robot, settings.id, seed, &plant, &law);
 *     for (;;) {
 *         uint32_t loops_ms = romano_loops_run(&loops, board.now_ms(board.self));
 *         uint32_t ms = romano_run(&robot);
 *         my_board_wait(loops_ms < ms ? loops_ms : ms);
 *     }
 *
 * where on_message() hands everything to romano_loops_on_message() first. Time is in milliseconds
 * here, and so are ages. No heap. One thread calls these functions. */
#ifndef ROMANO_FIRMWARE_ROBOT_CONTROL_H
#define ROMANO_FIRMWARE_ROBOT_CONTROL_H

#include <stdbool.h>
#include <stdint.h>

#include "firmware/robot/romano.h"

#ifdef __cplusplus
extern "C" {
#endif

#define ROMANO_PLANT_CHANNELS 2U
#define ROMANO_LAW_PLACES 4U

enum romano_fallback { ROMANO_STOP = 0, ROMANO_HOLD = 1, ROMANO_OWN_LAW = 2 };

/* What a robot does whose channels 0 and 1 others may control. */
struct romano_plant {
    void* self;
    /* Writes what the sensor says into `room`, returns its size, `most` at most. */
    uint32_t (*sense)(void* self, uint8_t channel, uint8_t* room, uint32_t most);
    /* A command whose sample is younger than the deadline: each once, in order. */
    void (*carry_out)(void* self, uint8_t channel, const uint8_t* value, uint32_t size);
    /* No such command is there now: once, until the next carry_out(). */
    void (*fall_back)(void* self, uint8_t channel, enum romano_fallback fallback);
};

struct romano_sample {
    uint32_t sequence;
    uint32_t tick_us; /* the plant's clock; differences are of use */
    uint16_t age;     /* of the last command when it was carried out, 0.1 ms; 0xFFFF: none yet */
    const uint8_t* value;
    uint32_t size;
};

/* How a robot controls others; up to four loops, each in a place from 0 on. */
struct romano_law {
    void* self;
    /* Whether it has that law and can use these parameters. */
    bool (*begin)(void* self, uint8_t place, const char plant[9], uint16_t law,
                  const uint8_t* parameters, uint32_t size);
    /* Writes the command into `room`, returns its size, `most` at most; below 0: no command. */
    int32_t (*control)(void* self, uint8_t place, const struct romano_sample* sample, uint8_t* room,
                       uint32_t most);
    /* The place is free. May be null. */
    void (*end)(void* self, uint8_t place);
};

#define ROMANO_LOOPS_OCTETS 2048U

/* Use the functions only. */
struct romano_loops {
    uint64_t storage[ROMANO_LOOPS_OCTETS / 8U];
};

/* False when the id is none. `plant` or `law` may be null; what they and `robot` point to must
 * stay. `seed` differs between robots, and between starts of one where that is possible. */
bool romano_loops_start(struct romano_loops* loops, struct romano_robot* robot, const char* id,
                        uint64_t seed, const struct romano_plant* plant,
                        const struct romano_law* law);

/* Of everything that romano_controller.on_message is told: true when it belonged to a loop. */
bool romano_loops_on_message(struct romano_loops* loops, uint64_t now_ms, const uint8_t* message,
                             uint32_t size);

/* Does all that is due, fall_back() included; returns in how many milliseconds it wants to be
 * called again at the latest. Call it before romano_run(). */
uint32_t romano_loops_run(struct romano_loops* loops, uint64_t now_ms);

#ifdef __cplusplus
}
#endif

#endif /* ROMANO_FIRMWARE_ROBOT_CONTROL_H */
