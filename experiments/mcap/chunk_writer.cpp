#include "experiments/mcap/chunk_writer.h"

#include <algorithm>

#include "experiments/mcap/compression.h"

namespace romano::experiments::mcap {

Octets ChunkWriter::beginning(std::string_view library) const {
    Octets out{magic.begin(), magic.end()};
    write_header(out, library);
    write_schema(out, schema_);
    return out;
}

ChunkWriter::Written* ChunkWriter::channel_for(std::string_view topic, std::string_view kind) {
    key_.assign(kind).append("/").append(topic);
    if (const auto found = channels_.find(key_); found != channels_.end()) return &found->second;
    if (channels_.size() >= most_channels || name_octets_ + topic.size() > most_name_octets) {
        return nullptr;
    }
    name_octets_ += topic.size();
    const auto id = static_cast<std::uint16_t>(channels_.size() + 1);
    write_channel(new_channels_, {.id = id,
                                  .schema_id = schema_.id,
                                  .topic = std::string{topic},
                                  .message_encoding = message_encoding_,
                                  .metadata = {{"topic_type", std::string{kind}}}});
    return &channels_.emplace(key_, Written{.id = id}).first->second;
}

bool ChunkWriter::add(Timestamp time, std::string_view topic, std::string_view kind, Bytes data) {
    Written* channel = channel_for(topic, kind);
    if (channel == nullptr) return false;
    start_ = records_.empty() ? time : std::min(start_, time);
    end_ = records_.empty() ? time : std::max(end_, time);
    entries_[channel->id].push_back({.time = time, .offset = records_.size()});
    write_message(records_, {.channel_id = channel->id,
                             .sequence = ++channel->sequence,
                             .log_time = time,
                             .publish_time = time,
                             .data = data});
    return true;
}

Octets ChunkWriter::take_chunk() {
    Octets out = std::move(new_channels_);
    new_channels_.clear();
    if (records_.empty()) return out;
    const Octets packed = compressed_with_zstd(records_);
    const bool is_smaller = !packed.empty() && packed.size() < records_.size();
    write_chunk(out,
                {.start = start_,
                 .end = end_,
                 .uncompressed_octets = records_.size(),
                 .uncompressed_crc = crc32_of(records_),
                 .compression = is_smaller ? zstd : std::string_view{}},
                is_smaller ? packed : records_);
    for (const auto& [channel, entries] : entries_) {
        RecordWriter index{out, Opcode::message_index};
        index.u16(channel).list(entries.size() * 16);
        for (const Entry& entry : entries) index.u64(entry.time).u64(entry.offset);
    }
    records_.clear();
    entries_.clear();
    return out;
}

}  // namespace romano::experiments::mcap
