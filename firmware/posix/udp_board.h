/* A board whose radio is a UDP socket of the operating system: Linux, macOS, BSD, QNX... */
#ifndef ROMANO_FIRMWARE_POSIX_UDP_BOARD_H
#define ROMANO_FIRMWARE_POSIX_UDP_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#include "firmware/robot/board.h"

#ifdef __cplusplus
extern "C" {
#endif

struct romano_udp_board {
    struct romano_board board; /* for romano_start() */
    int socket;
    int cell;                    /* hears the group of a broker's cell; -1: none */
    struct romano_address group; /* where discovery asks: 225.1.1.1:1883, or ff02::225:1:1:1 */
    bool has_any_ipv4;           /* then discovery asks on this machine, too */
    uint8_t datagram[2048];
};

/* "127.0.0.1", "fd00::1" or "fe80::1%eth0" and a port. False when the text is no IP address. */
bool romano_udp_address(const char* ip, uint16_t port, struct romano_address* address);

/* Opens the socket at `local`, port 0 for any; its family is the one that is spoken, and discovery
 * goes out by its interface; at 0.0.0.0 by the usual one and by the loopback. Returns 0 or
 * an errno. The board stays where it is. */
int romano_udp_open(struct romano_udp_board* udp, const struct romano_address* local);
/* Hears that multicast group too, by the interface of `local` of romano_udp_open(); at 0.0.0.0 by
 * the usual one and by the loopback. For what a broker sends once for many
 * (romano_settings.listens_to_cell). Returns 0 or an errno. */
int romano_udp_listen(struct romano_udp_board* udp, const struct romano_address* local,
                      const struct romano_address* group);
void romano_udp_close(struct romano_udp_board* udp);

/* Waits until a datagram is there, at most so long. */
void romano_udp_wait(const struct romano_udp_board* udp, uint32_t ms);

#ifdef __cplusplus
}
#endif

#endif /* ROMANO_FIRMWARE_POSIX_UDP_BOARD_H */
