/* The mailbox from a controller that is written in C. */
#include "romano/node/mailbox.h"

uint32_t front_millimetres_in_c(struct romano_mailbox* box);

uint32_t front_millimetres_in_c(struct romano_mailbox* box) {
    struct romano_command command;
    uint32_t sum = 0;
    while (romano_mailbox_get(box, &command)) {
        if (command.type == 0U) sum += romano_command_amount(&command);
    }
    return sum;
}
