/* What ROMANO needs of a robot's board, for C and C++: four functions. "Put this on your robot" in
 * firmware/README.md shows how they are filled in. */
#ifndef ROMANO_FIRMWARE_ROBOT_BOARD_H
#define ROMANO_FIRMWARE_ROBOT_BOARD_H

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A UDP address. Family 0 is the discovery group: multicast or broadcast, as the network has it. */
struct romano_address {
    uint8_t ip[16]; /* IPv4 in the first four octets */
    uint32_t scope; /* the interface of a link-local IPv6 address, else 0 */
    uint16_t port;
    uint8_t family; /* 0, 4 or 6 */
};

#define ROMANO_LINK_UNKNOWN 127

struct romano_board {
    void* self; /* handed to each function */

    /* A clock that never goes back. */
    uint64_t (*now_ms)(void* self);

    /* Datagrams may be lost, so a full buffer is no error. The octets are valid during the call. */
    void (*send)(void* self, const struct romano_address* to, const uint8_t* octets, uint32_t size);

    /* The next datagram that has come, with its size and sender, or null. Valid until the next
     * call. */
    const uint8_t* (*receive)(void* self, struct romano_address* from, uint32_t* size);

    /* How strongly the radio hears that address, in dBm, or ROMANO_LINK_UNKNOWN: then the time
     * that an answer takes counts. May be null. */
    int (*link_dbm)(void* self, const struct romano_address* peer);
};

#ifdef __cplusplus
}
#endif

#endif /* ROMANO_FIRMWARE_ROBOT_BOARD_H */
