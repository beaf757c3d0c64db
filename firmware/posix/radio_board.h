// A simulated radio between a robot and its socket: some datagrams get through, and the robot is
// told how strongly each was heard.
#pragma once

#include <optional>
#include <vector>

#include "firmware/posix/udp_board.h"

namespace romano::firmware {

/// The world as one robot's radio sees it.
class Radio {
public:
    virtual ~Radio() = default;
    /// Whom a broadcast goes to; each may still be out of range.
    virtual std::vector<romano_address> neighbours() = 0;
    /// Whether a datagram to or from there gets through now.
    virtual bool carries_to(const romano_address& peer) = 0;
    virtual bool carries_from(const romano_address& peer) = 0;
    /// How strongly it was heard lately; empty when it was not.
    virtual std::optional<int> dbm(const romano_address& peer) = 0;
};

/// The board with that radio. Both, and this, stay where they are.
class RadioBoard {
public:
    RadioBoard(const romano_board& board, Radio& radio);
    RadioBoard(const RadioBoard&) = delete;
    RadioBoard& operator=(const RadioBoard&) = delete;

    [[nodiscard]] const romano_board& board() const { return own_; }

private:
    const romano_board& socket_;
    Radio& radio_;
    romano_board own_{};
};

}  // namespace romano::firmware
