#include "romano/protection/sealer.h"

namespace romano::protection {

std::size_t Sealer::seal(RunId run, Bytes message, MutableBytes out, Refusals& refusals) {
    const auto refuse = [&](Refusal why) {
        refusals.count(why);
        return std::size_t{0};
    };
    if (next_ >= max_number) return refuse(Refusal::used_up);
    if (!reserve_.has(next_)) return refuse(Refusal::unstored);
    const std::size_t size = write({self_, run, next_}, message, key_, out);
    if (size == 0) return refuse(Refusal::too_long);
    reserve_.on_used(next_++);
    return size;
}

void Sealer::skip_block() {
    if (next_ >= max_number || next_ == Reserve::block_of(next_)) return;
    next_ = Reserve::block_of(next_) + numbers_a_block;
    reserve_.on_used(next_ - 1);
}

}  // namespace romano::protection
