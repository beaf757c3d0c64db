/* Loaded into programs under qemu-user by arm64-run. qemu-user (7.2) knows no IP_MULTICAST_IF, without which
 * Cyclone DDS does not start. It does as well without: Linux sends multicasts by the interface of the socket's
 * address. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <netinet/in.h>
#include <sys/socket.h>

int setsockopt(int socket, int level, int name, const void* value, socklen_t size) {
    int (*system_call)(int, int, int, const void*, socklen_t) = dlsym(RTLD_NEXT, "setsockopt");
    const int result = system_call(socket, level, name, value, size);
    const int lacks = result != 0 && errno == ENOPROTOOPT;
    return lacks && level == IPPROTO_IP && name == IP_MULTICAST_IF ? 0 : result;
}
