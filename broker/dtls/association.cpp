#include "broker/dtls/association.h"

#include <algorithm>
#include <utility>

namespace romano::dtls {
namespace {

// RFC 9000 section 8.1 has this bound for addresses that did not answer: no amplifier.
constexpr std::uint32_t times_what_came = 3;

}  // namespace

Association::Association(AssociationId id, const Path& path, const RecordKeys& keys,
                         const std::optional<ConnectionId>& clients_id)
    : keys_(keys),
      path_(path),
      at_(path.from),
      id_(id),
      clients_id_(clients_id.value_or(ConnectionId{})),
      may_roam_(clients_id.has_value()) {}

Association::Association(AssociationId id, const Path& path, const RecordKeys& keys,
                         const Progress& told, const Speaker& self,
                         const std::optional<Roaming>& roaming)
    : keys_(keys),
      path_(path),
      at_(roaming ? roaming->at : path.from),
      id_(id),
      clients_id_(roaming ? roaming->id : ConnectionId{}),
      may_roam_(roaming.has_value()),
      window_(std::min(told.floor, most_number)),
      turn_(told.turn),
      // Above whatever an earlier life of this broker, or of this object, may have used.
      count_(self.reserve.unused()),
      is_first_(told.floor > 0) {}

Result<Opened, Refusal> Association::open(RecordCipher& cipher, const Record& record,
                                          MutableBytes out) {
    if (window_.has_seen(record.number)) return Refusal::replayed;
    const auto opened = cipher.open(keys_.suite, keys_.client, record, out);
    if (!opened) return Refusal::bad_tag;
    if (std::exchange(is_first_, false)) {
        window_ = protection::WindowOf<std::uint64_t>{record.number + 1};
    } else {
        window_.note(record.number);
    }
    return *opened;
}

Result<std::size_t, Refusal> Association::seal(RecordCipher& cipher, const Speaker& self,
                                               ContentType type, Bytes message, MutableBytes out) {
    if (self.place == 0 || count_ >= most_count || (!is_own_turn_ && turn_.is_last())) {
        return Refusal::used_up;
    }
    if (!self.reserve.has(count_)) return Refusal::unstored;
    const Bytes id = clients_id_.octets();
    if (message.size() + overhead(keys_.suite, id.size()) > allowance_) return Refusal::unanswered;
    if (!std::exchange(is_own_turn_, true)) turn_ = turn_.next_of(self.place);
    const std::size_t size =
        cipher.seal(keys_.suite, keys_.server, type, turn_.number(count_), message, out, id);
    // Also when it was not sealed: nobody knows how far libcrypto came.
    self.reserve.on_used(count_++);
    if (size == 0) return Refusal::too_long;
    if (!has_answered()) allowance_ -= static_cast<std::uint32_t>(size);
    return size;
}

bool Association::on_newest_from(const Endpoint& at, std::size_t octets) {
    const auto more = times_what_came * static_cast<std::uint32_t>(octets);
    if (at == at_) {
        if (!has_answered()) allowance_ = std::min(allowance_ + more, unlimited - 1);
        return false;
    }
    at_ = at;
    allowance_ = more;
    return true;
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

void Association::on_told(const Progress& told, const std::optional<Roaming>& roaming) {
    const bool has_newer = told.floor > window_.end() && told.floor <= most_number;
    if (has_newer && may_roam_ && roaming) at_ = roaming->at;
    (void)on_told(told);
}

}  // namespace romano::dtls
