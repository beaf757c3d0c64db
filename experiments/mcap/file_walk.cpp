#include "experiments/mcap/file_walk.h"

#include <algorithm>

namespace romano::experiments::mcap {

bool FileWalk::begins_well() {
    return std::ranges::equal(file_.read(0, magic.size()), magic);
}

std::optional<RecordPlace> FileWalk::next() {
    if (has_footer_) return std::nullopt;
    const Bytes head = file_.read(at_, record_head);
    if (head.size() < record_head || head[0] == 0) return std::nullopt;  // 0 is no opcode
    FieldReader fields{head.subspan(1)};
    const RecordPlace place{
        .opcode = static_cast<Opcode>(head[0]), .offset = at_, .field_octets = fields.u64()};
    if (place.field_octets > file_.size() - place.fields_at()) return std::nullopt;
    at_ = place.end();
    has_footer_ = place.opcode == Opcode::footer;
    return place;
}

bool FileWalk::is_finished() {
    return has_footer_ && std::ranges::equal(file_.read(at_, magic.size()), magic);
}

}  // namespace romano::experiments::mcap
