#include "experiments/operator/own_id.h"

#include <unistd.h>

#include <cstdio>
#include <string_view>

#include "romano/base/fnv1a.h"

namespace romano::experiments {

message::RomanoId id_of_this_machine() {
    char host[256] = {};
    (void)::gethostname(host, sizeof host - 1);
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", fnv1a<std::uint32_t>(std::string_view{host}));
    return *message::RomanoId::parse(digits);
}

}  // namespace romano::experiments
