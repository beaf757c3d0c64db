/* ROMANO for a robot's program in C. Fill in a romano_board (board.h), start, and call romano_run()
 * from the main loop; commands wait in the mailbox until the movement controller takes them.
 *
 *     static struct romano_robot robot;
 *     romano_start(&robot, &settings, &board, NULL);
 *     for (;;) {
 *         uint32_t ms = romano_run(&robot);
 *         struct romano_command command;
 *         while (romano_next_command(&robot, &command)) move(&command);
 *         my_board_wait(ms); // until a datagram comes, or for so long
 *     }
 *
 * No heap, no operating system. One thread calls these functions. */
#ifndef ROMANO_FIRMWARE_ROBOT_ROMANO_H
#define ROMANO_FIRMWARE_ROBOT_ROMANO_H

#include <stdbool.h>
#include <stdint.h>

#include "firmware/robot/board.h"
#include "romano/node/mailbox.h"

#ifdef __cplusplus
extern "C" {
#endif

struct romano_settings {
    const char* id;               /* 8 lower-case hexadecimal digits: romano_id_of() */
    struct romano_address broker; /* family 0: the nearest one that discovery finds */
    uint16_t keep_alive_s;        /* 0: 30 */
    uint16_t heartbeat_s;         /* 0: none */
    bool keep_session;            /* the broker keeps messages while the robot is away */
    bool listens_to_cell;         /* to what the broker sends once for many */
    uint64_t seed;                /* differs between robots, a serial number for example */
};

/* What the robot's program is told within romano_run(); each may be null. Texts and data are valid
 * during the call and are not ended by NUL. */
struct romano_controller {
    void* self;
    void (*on_established)(void* self);
    /* "Publish that kind of data to that topic": answer with romano_publish(). */
    void (*on_publish_request)(void* self, const char* topic, uint32_t topic_size,
                               const uint8_t* kind, uint32_t kind_size);
    /* A whole ROMANO message: octet 0 is its type, octet 1 its size. Movements go to the mailbox
     * instead. */
    void (*on_message)(void* self, const char* topic, uint32_t topic_size, const uint8_t* message,
                       uint32_t size);
};

#define ROMANO_ROBOT_OCTETS 3584U

/* Use the functions only. */
struct romano_robot {
    uint64_t storage[ROMANO_ROBOT_OCTETS / 8U];
};

/* The last 8 digits of an IPv6 address, and NUL. */
void romano_id_of(const uint8_t ipv6[16], char id[9]);

/* False when the id is none. `board` and `controller` must stay; `controller` may be null. */
bool romano_start(struct romano_robot* robot, const struct romano_settings* settings,
                  const struct romano_board* board, const struct romano_controller* controller);

/* Does all that is due; returns in how many milliseconds it wants to be called again at the
 * latest. */
uint32_t romano_run(struct romano_robot* robot);

/* The oldest movement command; false when there is none. */
bool romano_next_command(struct romano_robot* robot, struct romano_command* command);

/* A ROMANO message of that type with that data. False when it cannot be taken now. */
bool romano_publish(struct romano_robot* robot, const char* topic, uint8_t type,
                    const uint8_t* data, uint32_t size, int qos);
bool romano_subscribe(struct romano_robot* robot, const char* topic);

/* Says goodbye, so that the robot is known to be gone at once. romano_run() repeats it until the
 * broker confirms; nothing else happens any more until romano_start(). */
void romano_leave(struct romano_robot* robot);

/* A ROMANO server knows the robot, and it hears its topics. */
bool romano_is_established(const struct romano_robot* robot);

#ifdef __cplusplus
}
#endif

#endif /* ROMANO_FIRMWARE_ROBOT_ROMANO_H */
