// What the system call that just failed left in errno.
#pragma once

#include <boost/system/error_code.hpp>
#include <cerrno>

namespace romano::net {

inline boost::system::error_code last_error() {
    return {errno, boost::system::system_category()};
}

}  // namespace romano::net
