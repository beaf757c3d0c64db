// Keys on their way between brokers.

#include "broker/dtls/wrapped_keys.h"

#include <gtest/gtest.h>

namespace romano::dtls::wrapped_keys_test {
namespace {

const RecordKeys keys{Suite::aes_128_gcm, {{1}, {2}}, {{3}, {4}}};
const protection::RobotKey client{{9, 8, 7}};

TEST(WrappedKeys, AreUnwrappedForTheSameClientAndAssociationAlone) {
    const WrappedKeys wrapped = wrap(keys, client, "a", AssociationId{5});
    EXPECT_EQ(unwrap(wrapped, client, "a", AssociationId{5}), keys);
    EXPECT_FALSE(unwrap(wrapped, client, "b", AssociationId{5}));
    EXPECT_FALSE(unwrap(wrapped, client, "a", AssociationId{6}));
    EXPECT_FALSE(unwrap(wrapped, {{9, 8, 6}}, "a", AssociationId{5}));
    for (std::size_t at = 0; at < wrapped.size(); ++at) {
        WrappedKeys changed = wrapped;
        changed[at] ^= 1U;
        EXPECT_FALSE(unwrap(changed, client, "a", AssociationId{5})) << at;
    }
    EXPECT_FALSE(unwrap(Bytes{wrapped}.first(wrapped_octets - 1), client, "a", AssociationId{5}));
}

TEST(WrappedKeys, ShowNothingOfTheKeys) {
    const WrappedKeys wrapped = wrap(keys, client, "a", AssociationId{5});
    const WrappedKeys other = wrap(keys, client, "a", AssociationId{6});
    EXPECT_NE(wrapped, other);
}

}  // namespace
}  // namespace romano::dtls::wrapped_keys_test
