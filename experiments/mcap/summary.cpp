#include "experiments/mcap/summary.h"

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "experiments/mcap/compression.h"

namespace romano::experiments::mcap {
namespace {

constexpr std::size_t part_octets = 1UL << 20U;
constexpr std::size_t entry_octets = 16;

/// A chunk and the indexes behind it.
struct IndexedChunk {
    RecordPlace place;
    std::map<std::uint16_t, std::uint64_t> index_offsets;
    std::uint64_t index_octets = 0;
};

class Summary {
public:
    Summary(OctetSource& file, const Append& append)
        : file_(file), append_(append), offset_(file.size()) {}

    bool write() {
        look_at_all();
        write_data_end(out_);
        const std::uint64_t start = offset();
        if (!flush()) return false;
        crc_ = 0;
        std::vector<Group> groups;
        groups.push_back(group(Opcode::schema, schemas_));
        groups.push_back(group(Opcode::channel, channels_));
        const std::uint64_t statistics_at = offset();
        write_statistics();
        groups.push_back({Opcode::statistics, statistics_at, offset() - statistics_at});
        const std::uint64_t indexes_at = offset();
        if (!write_chunk_indexes()) return false;
        groups.push_back({Opcode::chunk_index, indexes_at, offset() - indexes_at});
        const std::uint64_t offsets_at = offset();
        for (const Group& one : groups) {
            if (one.octets == 0) continue;
            RecordWriter{out_, Opcode::summary_offset}
                .octets(std::array{static_cast<std::uint8_t>(one.opcode)})
                .u64(one.at)
                .u64(one.octets);
        }
        return write_footer(start, offsets_at);
    }

private:
    struct Group {
        Opcode opcode;
        std::uint64_t at;
        std::uint64_t octets;
    };

    [[nodiscard]] std::uint64_t offset() const { return offset_ + out_.size(); }

    bool flush() {
        crc_ = crc32_of(out_, crc_);
        offset_ += out_.size();
        const bool is_written = append_(out_);
        out_.clear();
        return is_written;
    }

    Group group(Opcode opcode, const Octets& records) {
        const Group made{opcode, offset(), records.size()};
        out_.insert(out_.end(), records.begin(), records.end());
        return made;
    }

    void look_at_all() {
        FileWalk walk{file_};
        while (const auto place = walk.next()) {
            if (place->opcode == Opcode::schema) copy(*place, schemas_, statistics_.schemas);
            if (place->opcode == Opcode::channel) copy(*place, channels_, statistics_.channels);
            if (place->opcode == Opcode::chunk) count_chunk(*place);
            if (place->opcode == Opcode::message_index) count_messages(*place);
        }
    }

    template <typename Count>
    void copy(const RecordPlace& place, Octets& to, Count& count) {
        const Bytes record =
            file_.read(place.offset, static_cast<std::size_t>(place.end() - place.offset));
        to.insert(to.end(), record.begin(), record.end());
        ++count;
    }

    [[nodiscard]] Chunk chunk_at(const RecordPlace& place) {
        Chunk chunk;
        std::size_t records_at = 0;
        const std::size_t most = std::min<std::uint64_t>(place.field_octets, longest_chunk_head);
        (void)read_chunk(file_.read(place.fields_at(), most), chunk, records_at);
        return chunk;
    }

    void count_chunk(const RecordPlace& place) {
        const Chunk chunk = chunk_at(place);
        const bool is_first = statistics_.chunks++ == 0;
        statistics_.start = is_first ? chunk.start : std::min(statistics_.start, chunk.start);
        statistics_.end = std::max(statistics_.end, chunk.end);
    }

    void count_messages(const RecordPlace& place) {
        FieldReader fields{file_.read(place.fields_at(), 6)};
        const std::uint16_t channel = fields.u16();
        const std::uint64_t messages = fields.u32() / entry_octets;
        messages_[channel] += messages;
        statistics_.messages += messages;
    }

    void write_statistics() {
        RecordWriter record{out_, Opcode::statistics};
        constexpr std::uint32_t none = 0;  // attachments, metadata
        record.u64(statistics_.messages)
            .u16(statistics_.schemas)
            .u32(statistics_.channels)
            .u32(none)
            .u32(none)
            .u32(statistics_.chunks)
            .u64(statistics_.start)
            .u64(statistics_.end)
            .list(messages_.size() * 10);
        for (const auto& [channel, count] : messages_) record.u16(channel).u64(count);
    }

    bool write_chunk_indexes() {
        FileWalk walk{file_};
        std::optional<IndexedChunk> chunk;
        bool goes_on = true;
        while (goes_on) {
            const auto place = walk.next();
            goes_on = place && place->opcode != Opcode::data_end;  // the summary grows behind it
            const bool is_index = place && place->opcode == Opcode::message_index;
            if (is_index && chunk) {
                FieldReader fields{file_.read(place->fields_at(), 2)};
                chunk->index_offsets[fields.u16()] = place->offset;
                chunk->index_octets += place->end() - place->offset;
                continue;
            }
            if (chunk) write_chunk_index(*chunk);
            chunk.reset();
            if (goes_on && place->opcode == Opcode::chunk) chunk.emplace().place = *place;
            if (out_.size() >= part_octets && !flush()) return false;
        }
        return true;
    }

    void write_chunk_index(const IndexedChunk& indexed) {
        const Chunk chunk = chunk_at(indexed.place);
        const std::string compression{chunk.compression};
        RecordWriter record{out_, Opcode::chunk_index};
        record.u64(chunk.start)
            .u64(chunk.end)
            .u64(indexed.place.offset)
            .u64(indexed.place.end() - indexed.place.offset)
            .list(indexed.index_offsets.size() * 10);
        for (const auto& [channel, at] : indexed.index_offsets) record.u16(channel).u64(at);
        record.u64(indexed.index_octets)
            .text(compression)
            .u64(chunk.record_octets)
            .u64(chunk.uncompressed_octets);
    }

    /// Its checksum covers the summary and the footer up to the checksum itself.
    bool write_footer(std::uint64_t start, std::uint64_t offsets_at) {
        if (!flush()) return false;
        RecordWriter{out_, Opcode::footer}.u64(start).u64(offsets_at).u32(0);
        const Bytes summed = Bytes{out_}.first(out_.size() - 4);
        std::uint32_t crc = crc32_of(summed, crc_);
        for (std::size_t at = summed.size(); at < out_.size(); ++at, crc >>= 8U) {
            out_[at] = static_cast<std::uint8_t>(crc);
        }
        out_.insert(out_.end(), magic.begin(), magic.end());
        return flush();
    }

    OctetSource& file_;
    const Append& append_;
    std::uint64_t offset_;
    Octets out_;
    std::uint32_t crc_ = 0;
    Octets schemas_;
    Octets channels_;
    Statistics statistics_;
    std::map<std::uint16_t, std::uint64_t> messages_;
};

}  // namespace

bool append_summary(OctetSource& data_section, const Append& append) {
    return Summary{data_section, append}.write();
}

}  // namespace romano::experiments::mcap
