#include "romano/keys/random_octets.h"

#include <sys/random.h>

#include "romano/keys/key_error.h"

namespace romano::keys {

void fill_at_random(MutableBytes octets) {
    if (getentropy(octets.data(), octets.size()) != 0) {
        throw KeyError("the system gives no random octets for a key");
    }
}

}  // namespace romano::keys
