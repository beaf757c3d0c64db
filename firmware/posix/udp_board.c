#define _GNU_SOURCE
#include "firmware/posix/udp_board.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <stddef.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

union any_address {
    struct sockaddr any;
    struct sockaddr_in v4;
    struct sockaddr_in6 v6;
};

static socklen_t to_socket(const struct romano_address* from, union any_address* to) {
    memset(to, 0, sizeof *to);
    if (from->family == 4) {
        to->v4.sin_family = AF_INET;
        to->v4.sin_port = htons(from->port);
        memcpy(&to->v4.sin_addr, from->ip, 4);
        return sizeof to->v4;
    }
    to->v6.sin6_family = AF_INET6;
    to->v6.sin6_port = htons(from->port);
    to->v6.sin6_scope_id = from->scope;
    memcpy(&to->v6.sin6_addr, from->ip, 16);
    return sizeof to->v6;
}

static void from_socket(const union any_address* from, struct romano_address* to) {
    memset(to, 0, sizeof *to);
    if (from->any.sa_family == AF_INET) {
        to->family = 4;
        to->port = ntohs(from->v4.sin_port);
        memcpy(to->ip, &from->v4.sin_addr, 4);
    } else {
        to->family = 6;
        to->port = ntohs(from->v6.sin6_port);
        to->scope = from->v6.sin6_scope_id;
        memcpy(to->ip, &from->v6.sin6_addr, 16);
    }
}

static uint64_t now_ms(void* self) {
    (void)self;
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (uint64_t)now.tv_sec * 1000U + (uint64_t)now.tv_nsec / 1000000U;
}

static bool is_any_ipv4(const struct romano_address* local) {
    static const uint8_t any[4];
    return local->family == 4 && memcmp(local->ip, any, sizeof any) == 0;
}

static void send_to(const struct romano_udp_board* udp, const struct romano_address* to,
                    const uint8_t* octets, uint32_t size) {
    union any_address address;
    const socklen_t length = to_socket(to, &address);
    /* An error may be that of an earlier datagram (ICMP); this one was not sent then. */
    for (int attempt = 0; attempt < 2; ++attempt) {
        if (sendto(udp->socket, octets, size, 0, &address.any, length) >= 0) return;
        if (errno != ECONNREFUSED) return;
    }
}

static void go_out_by(const struct romano_udp_board* udp, in_addr_t interface) {
    const struct in_addr address = {.s_addr = htonl(interface)};
    (void)setsockopt(udp->socket, IPPROTO_IP, IP_MULTICAST_IF, &address, sizeof address);
}

/* A broker that serves its own machine alone is asked there, by the loopback: no datagram that goes
 * out by another interface reaches it. IPv6 has no multicast on Linux' loopback. */
static void ask_this_machine(const struct romano_udp_board* udp, const uint8_t* octets,
                             uint32_t size) {
    go_out_by(udp, INADDR_LOOPBACK);
    send_to(udp, &udp->group, octets, size);
    go_out_by(udp, INADDR_ANY);
}

static void send_datagram(void* self, const struct romano_address* to, const uint8_t* octets,
                          uint32_t size) {
    const struct romano_udp_board* udp = self;
    const bool is_for_the_group = to->family == 0;
    if (is_for_the_group && udp->has_any_ipv4) ask_this_machine(udp, octets, size);
    send_to(udp, is_for_the_group ? &udp->group : to, octets, size);
}

static const uint8_t* receive_from(struct romano_udp_board* udp, int socket,
                                   struct romano_address* from, uint32_t* size) {
    for (int errors = 0; errors < 8; ++errors) {
        union any_address address = {0};
        socklen_t length = sizeof address;
        const ssize_t received =
            recvfrom(socket, udp->datagram, sizeof udp->datagram, 0, &address.any, &length);
        if (received >= 0) {
            from_socket(&address, from);
            *size = (uint32_t)received;
            return udp->datagram;
        }
        if (errno == EAGAIN || errno == EWOULDBLOCK) return NULL;
    }
    return NULL;
}

static const uint8_t* receive_datagram(void* self, struct romano_address* from, uint32_t* size) {
    struct romano_udp_board* udp = self;
    const uint8_t* datagram = receive_from(udp, udp->socket, from, size);
    if (datagram != NULL || udp->cell < 0) return datagram;
    return receive_from(udp, udp->cell, from, size);
}

bool romano_udp_address(const char* ip, uint16_t port, struct romano_address* address) {
    union any_address parsed;
    memset(&parsed, 0, sizeof parsed);
    char text[INET6_ADDRSTRLEN + IF_NAMESIZE + 1];
    const size_t length = strlen(ip);
    if (length >= sizeof text) return false;
    memcpy(text, ip, length + 1);
    char* percent = strchr(text, '%');
    if (percent != NULL) *percent = '\0';
    if (inet_pton(AF_INET, text, &parsed.v4.sin_addr) == 1) {
        parsed.v4.sin_family = AF_INET;
        parsed.v4.sin_port = htons(port);
    } else if (inet_pton(AF_INET6, text, &parsed.v6.sin6_addr) == 1) {
        parsed.v6.sin6_family = AF_INET6;
        parsed.v6.sin6_port = htons(port);
        parsed.v6.sin6_scope_id = percent != NULL ? if_nametoindex(percent + 1) : 0;
        if (percent != NULL && parsed.v6.sin6_scope_id == 0) return false;
    } else {
        return false;
    }
    from_socket(&parsed, address);
    return true;
}

static void choose_group(struct romano_udp_board* udp, const struct romano_address* local) {
    if (local->family == 4) {
        (void)romano_udp_address("225.1.1.1", 1883, &udp->group);
        struct in_addr interface;
        memcpy(&interface, local->ip, sizeof interface);
        (void)setsockopt(udp->socket, IPPROTO_IP, IP_MULTICAST_IF, &interface, sizeof interface);
    } else {
        (void)romano_udp_address("ff02::225:1:1:1", 1883, &udp->group);
        udp->group.scope = local->scope;
    }
}

int romano_udp_open(struct romano_udp_board* udp, const struct romano_address* local) {
    memset(udp, 0, sizeof *udp);
    udp->cell = -1;
    udp->socket = socket(local->family == 4 ? AF_INET : AF_INET6,
                         SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (udp->socket < 0) return errno;
    union any_address address;
    const socklen_t length = to_socket(local, &address);
    if (bind(udp->socket, &address.any, length) != 0) {
        const int error = errno;
        romano_udp_close(udp);
        return error;
    }
    udp->has_any_ipv4 = is_any_ipv4(local);
    choose_group(udp, local);
    udp->board.self = udp;
    udp->board.now_ms = now_ms;
    udp->board.send = send_datagram;
    udp->board.receive = receive_datagram;
    return 0;
}

static int join_ipv4(int socket, const union any_address* group, const uint8_t* interface) {
    struct ip_mreq request = {.imr_multiaddr = group->v4.sin_addr};
    memcpy(&request.imr_interface, interface, sizeof request.imr_interface);
    const int error = setsockopt(socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request);
    return error == 0 || errno == EADDRINUSE ? 0 : errno;
}

static int join(int socket, const union any_address* group, const struct romano_address* local) {
    if (group->any.sa_family == AF_INET6) {
        const struct ipv6_mreq request = {.ipv6mr_multiaddr = group->v6.sin6_addr,
                                          .ipv6mr_interface = group->v6.sin6_scope_id != 0
                                                                  ? group->v6.sin6_scope_id
                                                                  : local->scope};
        const int error =
            setsockopt(socket, IPPROTO_IPV6, IPV6_JOIN_GROUP, &request, sizeof request);
        return error == 0 ? 0 : errno;
    }
    if (!is_any_ipv4(local)) return join_ipv4(socket, group, local->ip);
    static const uint8_t loopback[4] = {127, 0, 0, 1};
    const int here = join_ipv4(socket, group, loopback);
    const int elsewhere = join_ipv4(socket, group, local->ip);
    return here == 0 ? 0 : elsewhere;
}

int romano_udp_listen(struct romano_udp_board* udp, const struct romano_address* local,
                      const struct romano_address* group) {
    union any_address address;
    const socklen_t length = to_socket(group, &address);
    udp->cell = socket(group->family == 4 ? AF_INET : AF_INET6,
                       SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (udp->cell < 0) return errno;
    const int yes = 1; /* other robots on this machine listen there, too */
    int error = 0;
    if (setsockopt(udp->cell, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) != 0 ||
        bind(udp->cell, &address.any, length) != 0) {
        error = errno;
    } else {
        error = join(udp->cell, &address, local);
    }
    if (error != 0) {
        close(udp->cell);
        udp->cell = -1;
    }
    return error;
}

void romano_udp_close(struct romano_udp_board* udp) {
    close(udp->socket);
    udp->socket = -1;
    if (udp->cell >= 0) close(udp->cell);
    udp->cell = -1;
}

void romano_udp_wait(const struct romano_udp_board* udp, uint32_t ms) {
    struct pollfd ready[] = {{.fd = udp->socket, .events = POLLIN, .revents = 0},
                             {.fd = udp->cell, .events = POLLIN, .revents = 0}}; /* -1: ignored */
    (void)poll(ready, 2, (int)ms);
}
