#include "experiments/testbed/ssh.h"

#include <gtest/gtest.h>

namespace romano::experiments::ssh_test {
namespace {

// scp(1): [user@]host:[path], with an IPv6 address in brackets, or scp://[user@]host[:port][/path].
TEST(Ssh, ADestinationOfSshIsOneOfScp) {
    for (const auto& [destination, target] :
         {std::pair{"pi1", "pi1:/tmp/x/"}, std::pair{"pi@192.168.1.11", "pi@192.168.1.11:/tmp/x/"},
          std::pair{"fd00::11", "[fd00::11]:/tmp/x/"},
          std::pair{"pi@fe80::1%eth0", "pi@[fe80::1%eth0]:/tmp/x/"},
          std::pair{"ssh://pi@pi1:2222", "scp://pi@pi1:2222//tmp/x/"}}) {
        EXPECT_EQ(scp_target(destination, "/tmp/x"), target);
    }
}

}  // namespace
}  // namespace romano::experiments::ssh_test
