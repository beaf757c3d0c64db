#include "broker/daemon/handshake_memory.h"

#include <malloc.h>

#include <utility>

namespace romano::daemon {

void give_free_memory_back() {
    (void)malloc_trim(0);
}

HandshakeMemory::HandshakeMemory(std::function<void()> give_back)
    : give_back_(std::move(give_back)) {}

void HandshakeMemory::on_time(Instant now, std::size_t going_on, std::uint64_t ended) {
    if (going_on != 0 || ended == ended_) return;
    if (last_ && now - *last_ < at_most_every) return;
    ended_ = ended;
    last_ = now;
    give_back_();
}

}  // namespace romano::daemon
