#include "broker/dtls/association.h"

#include <algorithm>
#include <utility>

namespace romano::dtls {

Association::Association(AssociationId id, const Path& path, const RecordKeys& keys,
                         const Progress& told, const Speaker& self)
    : keys_(keys),
      path_(path),
      id_(id),
      window_(std::min(told.floor, most_number)),
      turn_(told.turn),
      // Above whatever an earlier life of this broker, or of this object, may have used.
      count_(self.reserve.unused()),
      is_first_(told.floor > 0) {}

Result<std::size_t, Refusal> Association::open(RecordCipher& cipher, const Record& record,
                                               MutableBytes out) {
    if (window_.has_seen(record.number)) return Refusal::replayed;
    const auto size = cipher.open(keys_.suite, keys_.client, record, out);
    if (!size) return Refusal::bad_tag;
    if (std::exchange(is_first_, false)) {
        window_ = protection::WindowOf<std::uint64_t>{record.number + 1};
    } else {
        window_.note(record.number);
    }
    return *size;
}

Result<std::size_t, Refusal> Association::seal(RecordCipher& cipher, const Speaker& self,
                                               ContentType type, Bytes message, MutableBytes out) {
    if (self.place == 0 || count_ >= most_count || (!is_own_turn_ && turn_.is_last())) {
        return Refusal::used_up;
    }
    if (!self.reserve.has(count_)) return Refusal::unstored;
    if (!std::exchange(is_own_turn_, true)) turn_ = turn_.next_of(self.place);
    const std::size_t size =
        cipher.seal(keys_.suite, keys_.server, type, turn_.number(count_), message, out);
    // Also when it was not sealed: nobody knows how far libcrypto came.
    self.reserve.on_used(count_++);
    if (size == 0) return Refusal::too_long;
    return size;
}

bool Association::on_told(const Progress& told) {
    const Progress before = progress();
    if (told.turn > turn_) {
        turn_ = told.turn;
        is_own_turn_ = false;
    }
    if (told.floor > window_.end() && told.floor <= most_number) {
        window_ = protection::WindowOf<std::uint64_t>{told.floor};
        is_first_ = true;
    }
    return progress() != before;
}

}  // namespace romano::dtls
