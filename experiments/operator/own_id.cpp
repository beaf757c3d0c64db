#include "experiments/operator/own_id.h"

#include <unistd.h>

#include <cstdio>
#include <string_view>

#include "overlay/cluster/digest.h"

namespace romano::experiments {

message::RomanoId id_of_this_machine() {
    char host[256] = {};
    (void)::gethostname(host, sizeof host - 1);
    cluster::Digest digest;
    digest.add(std::string_view{host});
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", digest.value());
    return *message::RomanoId::parse(digits);
}

}  // namespace romano::experiments
