// Both ends of a link ask, seldom, whether the other one is there: nothing else is said on it, and
// a machine that lost its power or was cut off closes nothing. The kernel answers, so a process
// that stands still is there.
#pragma once

#include <boost/asio/ip/tcp.hpp>

namespace romano::link {

/// The connection ends when its other end does not answer for a minute.
void keep_alive(boost::asio::ip::tcp::socket& socket);

}  // namespace romano::link
