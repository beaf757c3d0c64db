// A board whose robot's datagrams are protected: what it sends is sealed, what it is sent is
// opened. Discovery stays as it is: what it hears there is a hint and no more.
#pragma once

#include <cstdint>
#include <vector>

#include "firmware/robot/board.h"
#include "romano/keys/client_packets.h"

namespace romano::firmware {

/// Around another board. Both, and the packets, stay where they are.
class ProtectedBoard {
public:
    ProtectedBoard(const romano_board& board, keys::ClientPackets& packets);
    ProtectedBoard(const ProtectedBoard&) = delete;
    ProtectedBoard& operator=(const ProtectedBoard&) = delete;

    [[nodiscard]] const romano_board& board() const { return own_; }

private:
    void send(const romano_address* to, Bytes message);
    const std::uint8_t* receive(romano_address* from, std::uint32_t* size);

    const romano_board& inner_;
    keys::ClientPackets& packets_;
    romano_board own_{};
    std::vector<std::uint8_t> packet_;  // as long as its message is read
};

}  // namespace romano::firmware
