/* The mailbox between ROMANO and a robot's movement controller: a bounded queue of movement
 * commands, for C and C++.
 *
 * One writer (the ROMANO node) and one reader (the controller), in two threads, or one of them in
 * an interrupt of a microcontroller: neither ever waits for the other. A full mailbox refuses the
 * newest command and counts it, for the commands before it were promised. Paper, section "ROMANO
 * Protocol Description".
 */
#ifndef ROMANO_NODE_MAILBOX_H
#define ROMANO_NODE_MAILBOX_H

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#ifdef __cplusplus
extern "C" {
#endif

#ifndef ROMANO_MAILBOX_COMMANDS    /* smaller where memory is scarce, in all files alike */
#define ROMANO_MAILBOX_COMMANDS 8U /* that wait; a power of two */
#endif
#define ROMANO_COMMAND_ARGUMENTS 32U /* octets; a longer command is refused */

/* A movement of ROMANO: octets 2-3 of the message, and the arguments behind them as they came. */
struct romano_command {
    uint16_t type; /* 0 front, 1 back, 2 left, 3 right (mm); 4, 5 rotate left, right (millidegrees);
                      0x8000... own */
    uint8_t size;  /* of arguments, octets */
    uint8_t arguments[ROMANO_COMMAND_ARGUMENTS];
};

/* All zero is an empty mailbox. Use the functions only. */
struct romano_mailbox {
    struct romano_command commands[ROMANO_MAILBOX_COMMANDS];
    uint32_t written; /* by the writer only; counts commands and wraps */
    uint32_t read;    /* by the reader only */
    uint32_t refused; /* by the writer only */
};

/* Writer: false when the mailbox is full or the command is too long; it is then counted and not
 * queued. */
static inline bool romano_mailbox_put(struct romano_mailbox* box, uint16_t type,
                                      const uint8_t* arguments, uint32_t size) {
    const uint32_t written = __atomic_load_n(&box->written, __ATOMIC_RELAXED);
    const uint32_t read = __atomic_load_n(&box->read, __ATOMIC_ACQUIRE);
    if (written - read == ROMANO_MAILBOX_COMMANDS || size > ROMANO_COMMAND_ARGUMENTS) {
        __atomic_store_n(&box->refused, __atomic_load_n(&box->refused, __ATOMIC_RELAXED) + 1U,
                         __ATOMIC_RELAXED);
        return false;
    }
    struct romano_command* slot = &box->commands[written % ROMANO_MAILBOX_COMMANDS];
    slot->type = type;
    slot->size = size & 0xFFU;
    if (size != 0U) memcpy(slot->arguments, arguments, size);
    __atomic_store_n(&box->written, written + 1U, __ATOMIC_RELEASE);
    return true;
}

/* Reader: the oldest command, or false when there is none. */
static inline bool romano_mailbox_get(struct romano_mailbox* box, struct romano_command* command) {
    const uint32_t read = __atomic_load_n(&box->read, __ATOMIC_RELAXED);
    const uint32_t written = __atomic_load_n(&box->written, __ATOMIC_ACQUIRE);
    if (read == written) return false;
    *command = box->commands[read % ROMANO_MAILBOX_COMMANDS];
    __atomic_store_n(&box->read, read + 1U, __ATOMIC_RELEASE);
    return true;
}

/* Commands that were refused since the start. */
static inline uint32_t romano_mailbox_refused(const struct romano_mailbox* box) {
    return __atomic_load_n(&box->refused, __ATOMIC_RELAXED);
}

/* The argument of the six standard movements, mm or millidegrees; 0 for others. */
static inline uint32_t romano_command_amount(const struct romano_command* command) {
    if (command->type > 5U || command->size != 4U) return 0U;
    uint32_t amount = 0U;
    for (uint32_t i = 0U; i < 4U; ++i) amount = (amount << 8U) | command->arguments[i];
    return amount;
}

#ifdef __cplusplus
}
#endif

#endif /* ROMANO_NODE_MAILBOX_H */
