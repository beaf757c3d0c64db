/* A movement controller in C: takes commands from ROMANO's mailbox and "moves".
 *
 *     controller_c abcd1234 127.0.0.1 1883 [COMMANDS]    ends after so many commands, if given
 */
#include <stdio.h>
#include <stdlib.h>

#include "firmware/posix/udp_board.h"
#include "firmware/robot/romano.h"

static void move(const struct romano_command* command) {
    static const char* const names[] = {"front", "back",        "left",
                                        "right", "rotate left", "rotate right"};
    if (command->type < 4) {
        printf("%s %u mm\n", names[command->type], (unsigned)romano_command_amount(command));
    } else if (command->type < 6) {
        printf("%s %u mdeg\n", names[command->type], (unsigned)romano_command_amount(command));
    } else {
        printf("movement 0x%04x with %u octets\n", (unsigned)command->type,
               (unsigned)command->size);
    }
    fflush(stdout);
}

int main(int argc, char** argv) {
    static struct romano_robot robot;
    static struct romano_udp_board udp;
    struct romano_settings settings = {0};
    struct romano_address local = {0};
    if (argc < 4 || !romano_udp_address(argv[2], (uint16_t)atoi(argv[3]), &settings.broker)) {
        fprintf(stderr, "usage: controller_c ID BROKER-IP PORT [COMMANDS]\n");
        return 2;
    }
    settings.id = argv[1];
    local.family = settings.broker.family;
    if (romano_udp_open(&udp, &local) != 0 || !romano_start(&robot, &settings, &udp.board, NULL)) {
        fprintf(stderr, "controller_c: no socket, or no id of 8 lower-case hexadecimal digits\n");
        return 2;
    }
    long left = argc > 4 ? atol(argv[4]) : -1;
    while (left != 0) {
        const uint32_t ms = romano_run(&robot);
        struct romano_command command;
        while (left != 0 && romano_next_command(&robot, &command)) {
            move(&command);
            --left;
        }
        if (left != 0) romano_udp_wait(&udp, ms);
    }
    romano_run(&robot); /* acknowledges the last one */
    romano_leave(&robot);
    romano_udp_close(&udp);
    return 0;
}
