// Messages become an MCAP file's data section: chunks, each behind the channels that are new in it
// and before its index. No file; who owns it writes what it gives, and finishes with summary.h.
//
// Bounded: a chunk grows until the owner takes it, and further channels than the most are refused.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "experiments/mcap/records.h"

namespace romano::experiments::mcap {

class ChunkWriter {
public:
    static constexpr std::size_t most_channels = 32'768;
    static constexpr std::size_t most_name_octets = 16UL << 20U;  // of all channels together

    /// All channels have this schema.
    explicit ChunkWriter(Schema schema, std::string message_encoding)
        : schema_(std::move(schema)), message_encoding_(std::move(message_encoding)) {}

    /// What stands before the first chunk: magic, header, schema.
    [[nodiscard]] Octets beginning(std::string_view library) const;

    /// `kind` is told in the channel's metadata as "topic_type": topics of different kinds may have
    /// the same name. False when there are too many channels.
    bool add(Timestamp time, std::string_view topic, std::string_view kind, Bytes data);

    /// Octets that wait for the next chunk; 0: none.
    [[nodiscard]] std::size_t waiting() const { return records_.size(); }
    /// What has been added since the last one; it goes into the file whole.
    [[nodiscard]] Octets take_chunk();

private:
    struct Entry {
        Timestamp time;
        std::uint64_t offset;  // in the uncompressed records
    };
    struct Written {
        std::uint16_t id;
        std::uint32_t sequence = 0;
    };

    Written* channel_for(std::string_view topic, std::string_view kind);

    Schema schema_;
    std::string message_encoding_;
    std::map<std::string, Written, std::less<>> channels_;  // by kind and topic
    std::string key_;
    std::size_t name_octets_ = 0;
    Octets new_channels_;
    Octets records_;
    std::map<std::uint16_t, std::vector<Entry>> entries_;
    Timestamp start_ = 0;
    Timestamp end_ = 0;
};

}  // namespace romano::experiments::mcap
