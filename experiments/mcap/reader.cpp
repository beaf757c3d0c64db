#include "experiments/mcap/reader.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "experiments/mcap/compression.h"

namespace romano::experiments::mcap {
namespace {

constexpr std::size_t longest_channel = 1UL << 20U;
/// Times fit into the signed nanoseconds of everybody else.
constexpr Timestamp latest = std::numeric_limits<std::int64_t>::max();

}  // namespace

Reader::Reader(OctetSource& file) : file_(file) {
    look_over();
}

void Reader::look_over() {
    FileWalk walk{file_};
    is_mcap_ = walk.begins_well();
    if (!is_mcap_) return;
    while (const auto place = walk.next()) {
        if (place->opcode == Opcode::chunk) {
            note_chunk(*place);
        } else if (place->opcode == Opcode::channel && place->field_octets <= longest_channel) {
            note_channel(
                file_.read(place->fields_at(), static_cast<std::size_t>(place->field_octets)));
        } else if (place->opcode == Opcode::message) {
            ++left_out_.messages_outside;
        }
    }
    is_finished_ = walk.is_finished();
    if (!is_finished_) left_out_.octets_cut = file_.size() - walk.sound_octets();
    std::ranges::stable_sort(chunks_, {}, &ChunkPlace::start);
}

void Reader::note_chunk(const RecordPlace& place) {
    const auto most = std::min<std::uint64_t>(place.field_octets, longest_chunk_head);
    Chunk chunk;
    std::size_t records_at = 0;
    if (!read_chunk(file_.read(place.fields_at(), static_cast<std::size_t>(most)), chunk,
                    records_at) ||
        chunk.end > latest || chunk.start > chunk.end ||
        chunk.record_octets > place.field_octets - records_at) {
        ++left_out_.chunks_damaged;
        return;
    }
    if (chunk.uncompressed_octets > most_chunk_octets ||
        place.field_octets > most_chunk_octets + longest_chunk_head) {
        ++left_out_.chunks_too_large;
        return;
    }
    if (!chunk.compression.empty() && chunk.compression != zstd) {
        ++left_out_.chunks_compressed;
        left_out_.compressions.emplace(chunk.compression);
        return;
    }
    if (chunks_.size() >= most_chunks) {
        ++left_out_.chunks_too_many;
        return;
    }
    if (chunk.end == 0) return;  // no messages
    start_ = chunks_.empty() ? chunk.start : std::min(start_, chunk.start);
    end_ = std::max(end_, chunk.end);
    chunks_.push_back({.fields_at = place.fields_at(),
                       .field_octets = place.field_octets,
                       .start = chunk.start,
                       .end = chunk.end});
}

void Reader::note_channel(Bytes fields) {
    Channel channel;
    if (!read_channel(fields, channel) || channels_.contains(channel.id)) return;
    if (channel_octets_ + fields.size() > most_channel_octets) return;
    channel_octets_ += fields.size();
    const std::uint16_t id = channel.id;
    channels_.emplace(id, std::move(channel));
}

bool Reader::unpack(const ChunkPlace& place) {
    const Bytes fields = file_.read(place.fields_at, static_cast<std::size_t>(place.field_octets));
    Chunk chunk;
    std::size_t records_at = 0;
    if (!read_chunk(fields, chunk, records_at)) return false;
    if (chunk.record_octets > fields.size() - records_at) return false;
    auto records = uncompressed(
        chunk.compression,
        fields.subspan(records_at, static_cast<std::size_t>(chunk.record_octets)),
        static_cast<std::size_t>(std::min(chunk.uncompressed_octets, most_chunk_octets)));
    if (!records) return false;
    constexpr std::uint32_t not_told = 0;
    if (chunk.uncompressed_crc != not_told && chunk.uncompressed_crc != crc32_of(*records)) {
        return false;
    }
    records_ = std::move(*records);
    return true;
}

void Reader::load(ChunkPlace& place) {
    messages_.clear();
    next_message_ = 0;
    const LeftOut before = left_out_;
    if (unpack(place)) {
        find_messages();
    } else {
        ++left_out_.chunks_damaged;
    }
    if (std::exchange(place.is_counted, true)) left_out_ = before;
}

void Reader::find_messages() {
    Bytes rest = records_;
    Opcode opcode{};
    Bytes fields;
    while (next_record(rest, opcode, fields)) {
        if (opcode == Opcode::channel) note_channel(fields);
        if (opcode != Opcode::message) continue;
        Message message;
        if (!read_message(fields, message) || message.log_time > latest ||
            !channels_.contains(message.channel_id)) {
            ++left_out_.messages_unknown;
            continue;
        }
        messages_.push_back({.time = message.log_time,
                             .channel = message.channel_id,
                             .at = static_cast<std::size_t>(message.data.data() - records_.data()),
                             .octets = message.data.size()});
    }
    std::ranges::stable_sort(messages_, {}, &Place::time);
}

std::optional<Reader::Told> Reader::next() {
    while (next_message_ >= messages_.size()) {
        if (next_chunk_ >= chunks_.size()) return std::nullopt;
        load(chunks_[next_chunk_++]);
    }
    const Place& place = messages_[next_message_++];
    return Told{.time = place.time,
                .channel = &channels_.at(place.channel),
                .data = Bytes{records_}.subspan(place.at, place.octets)};
}

void Reader::seek(Timestamp time) {
    const auto chunk = std::ranges::find_if(
        chunks_, [time](const ChunkPlace& place) { return place.end >= time; });
    next_chunk_ = static_cast<std::size_t>(chunk - chunks_.begin());
    messages_.clear();
    next_message_ = 0;
    if (chunk == chunks_.end()) return;
    load(chunks_[next_chunk_++]);
    while (next_message_ < messages_.size() && messages_[next_message_].time < time) {
        ++next_message_;
    }
}

}  // namespace romano::experiments::mcap
