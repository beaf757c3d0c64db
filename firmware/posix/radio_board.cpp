#include "firmware/posix/radio_board.h"

#include <cstdint>

namespace romano::firmware {

RadioBoard::RadioBoard(const romano_board& board, Radio& radio) : socket_(board), radio_(radio) {
    static const auto self_of = [](void* self) -> RadioBoard& {
        return *static_cast<RadioBoard*>(self);
    };
    own_.self = this;
    own_.now_ms = [](void* self) {
        return self_of(self).socket_.now_ms(self_of(self).socket_.self);
    };
    own_.send = [](void* self, const romano_address* to, const std::uint8_t* octets,
                   std::uint32_t size) {
        RadioBoard& own = self_of(self);
        std::vector<romano_address> receivers{*to};
        if (to->family == 0) receivers = own.radio_.neighbours();
        for (const romano_address& receiver : receivers) {
            if (own.radio_.carries_to(receiver)) {
                own.socket_.send(own.socket_.self, &receiver, octets, size);
            }
        }
    };
    own_.receive = [](void* self, romano_address* from, std::uint32_t* size) {
        RadioBoard& own = self_of(self);
        const std::uint8_t* octets = own.socket_.receive(own.socket_.self, from, size);
        while (octets != nullptr && !own.radio_.carries_from(*from)) {
            octets = own.socket_.receive(own.socket_.self, from, size);
        }
        return octets;
    };
    own_.link_dbm = [](void* self, const romano_address* peer) {
        return self_of(self).radio_.dbm(*peer).value_or(ROMANO_LINK_UNKNOWN);
    };
}

}  // namespace romano::firmware
