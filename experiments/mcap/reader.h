// The messages of an MCAP file in the order of their times, chunk after chunk, also of a file that
// was cut anywhere or that another program wrote; and what was lost or is left out. No file of its
// own.
//
// Bounded: one chunk is in memory, and what is larger or more than the limits is left out and
// counted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "experiments/mcap/file_walk.h"
#include "experiments/mcap/records.h"

namespace romano::experiments::mcap {

/// What next() does not tell, and why.
struct LeftOut {
    std::uint64_t octets_cut = 0;        // behind the last whole record
    std::uint64_t messages_outside = 0;  // of chunks
    std::uint64_t messages_unknown = 0;  // of a channel that was not told before, or malformed
    std::uint64_t chunks_damaged = 0;    // another checksum, or no such records
    std::uint64_t chunks_too_large = 0;
    std::uint64_t chunks_too_many = 0;
    std::set<std::string> compressions = {};  // that cannot be read
    std::uint64_t chunks_compressed = 0;      // with these
};

class Reader {
public:
    static constexpr std::uint64_t most_chunk_octets = 64UL << 20U;
    static constexpr std::size_t most_chunks = 4'000'000;  // 45 days of a chunk a second
    static constexpr std::size_t most_channel_octets = 64UL << 20U;

    struct Told {
        Timestamp time;
        const Channel* channel;  // never null; good as long as the reader
        Bytes data;              // good until the next call
    };

    /// Looks over the whole file, without what is in the chunks.
    explicit Reader(OctetSource& file);

    /// Else there is nothing else to be had of it.
    [[nodiscard]] bool is_mcap() const { return is_mcap_; }
    /// It was ended as it should be.
    [[nodiscard]] bool is_finished() const { return is_finished_; }
    /// Of the first and of the last message; equal for an empty recording.
    [[nodiscard]] Timestamp start() const { return start_; }
    [[nodiscard]] Timestamp end() const { return end_; }

    /// Empty at the end.
    std::optional<Told> next();
    /// next() goes on with the first message at `time` or after it.
    void seek(Timestamp time);

    /// Counts of chunks that were not come to yet are not in it.
    [[nodiscard]] const LeftOut& left_out() const { return left_out_; }

private:
    struct ChunkPlace {
        std::uint64_t fields_at;
        std::uint64_t field_octets;
        Timestamp start;
        Timestamp end;
        bool is_counted = false;  // what is wrong with it, in left_out_
    };
    struct Place {
        Timestamp time;
        std::uint16_t channel;
        std::size_t at;  // in records_
        std::size_t octets;
    };

    void look_over();
    void note_chunk(const RecordPlace& place);
    void note_channel(Bytes fields);
    void load(ChunkPlace& place);
    [[nodiscard]] bool unpack(const ChunkPlace& place);
    void find_messages();

    OctetSource& file_;
    bool is_mcap_ = false;
    bool is_finished_ = false;
    std::vector<ChunkPlace> chunks_;
    std::map<std::uint16_t, Channel> channels_;
    std::size_t channel_octets_ = 0;
    Timestamp start_ = 0;
    Timestamp end_ = 0;
    LeftOut left_out_;

    std::size_t next_chunk_ = 0;
    Octets records_;
    std::vector<Place> messages_;
    std::size_t next_message_ = 0;
};

}  // namespace romano::experiments::mcap
