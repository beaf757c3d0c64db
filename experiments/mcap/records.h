// The records of an MCAP file (https://mcap.dev/spec) as octets, one by one: an opcode, a length,
// and fields in little-endian order.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "romano/base/bytes.h"

namespace romano::experiments::mcap {

using Octets = std::vector<std::uint8_t>;
/// Nanoseconds since 1970, as all times in a file.
using Timestamp = std::uint64_t;

/// A file begins and ends with it.
inline constexpr std::array<std::uint8_t, 8> magic = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

enum class Opcode : std::uint8_t {
    header = 0x01,
    footer = 0x02,
    schema = 0x03,
    channel = 0x04,
    message = 0x05,
    chunk = 0x06,
    message_index = 0x07,
    chunk_index = 0x08,
    statistics = 0x0B,
    summary_offset = 0x0E,
    data_end = 0x0F,
};

/// The opcode and the length before the fields.
inline constexpr std::size_t record_head = 9;
/// The fields of a chunk before its records, with room for the name of any compression.
inline constexpr std::size_t longest_chunk_head = 128;

struct Schema {
    std::uint16_t id = 0;
    std::string name;
    std::string encoding;
    std::string data;
};

struct Channel {
    std::uint16_t id = 0;
    std::uint16_t schema_id = 0;
    std::string topic;
    std::string message_encoding;
    std::vector<std::pair<std::string, std::string>> metadata = {};

    /// Empty when there is none of that name.
    [[nodiscard]] std::string_view metadata_of(std::string_view name) const;
};

struct Message {
    std::uint16_t channel_id = 0;
    std::uint32_t sequence = 0;
    Timestamp log_time = 0;
    Timestamp publish_time = 0;
    Bytes data = {};
};

struct Chunk {
    Timestamp start = 0;  // of the earliest message
    Timestamp end = 0;
    std::uint64_t uncompressed_octets = 0;
    std::uint32_t uncompressed_crc = 0;  // 0: not told
    std::string_view compression = {};   // "", "zstd", "lz4"
    std::uint64_t record_octets = 0;     // as they stand in the file
};

struct Statistics {
    std::uint64_t messages = 0;
    std::uint16_t schemas = 0;
    std::uint32_t channels = 0;
    std::uint32_t chunks = 0;
    Timestamp start = 0;
    Timestamp end = 0;
};

/// Appends one record; the length is known when it ends.
class RecordWriter {
public:
    RecordWriter(Octets& out, Opcode opcode);
    ~RecordWriter();
    RecordWriter(const RecordWriter&) = delete;
    RecordWriter& operator=(const RecordWriter&) = delete;

    RecordWriter& u16(std::uint16_t value);
    RecordWriter& u32(std::uint32_t value);
    RecordWriter& u64(std::uint64_t value);
    RecordWriter& octets(Bytes value);
    /// With its length before it, in 32 bits.
    RecordWriter& text(std::string_view value);
    /// Of a list in octets, which follows.
    RecordWriter& list(std::size_t octet_count);

private:
    Octets& out_;
    std::size_t begin_;
};

void write_header(Octets& out, std::string_view library);
void write_schema(Octets& out, const Schema& schema);
void write_channel(Octets& out, const Channel& channel);
void write_message(Octets& out, const Message& message);
/// `records` as they are to stand in the file, `chunk` tells what they were.
void write_chunk(Octets& out, const Chunk& chunk, Bytes records);
void write_data_end(Octets& out);

/// Reads fields one after the other. What is not there is 0 or empty, and has_all() says so.
class FieldReader {
public:
    explicit FieldReader(Bytes octets) : rest_(octets) {}

    std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }
    std::uint32_t u32() { return static_cast<std::uint32_t>(number(4)); }
    std::uint64_t u64() { return number(8); }
    std::string_view text();
    Bytes list();

    [[nodiscard]] Bytes rest() const { return rest_; }
    [[nodiscard]] bool has_all() const { return has_all_; }

private:
    std::uint64_t number(std::size_t octets);
    Bytes take(std::uint64_t octets);

    Bytes rest_;
    bool has_all_ = true;
};

// False when the fields are no such record; fields that a later version adds are passed over.
[[nodiscard]] bool read_channel(Bytes fields, Channel& out);
[[nodiscard]] bool read_message(Bytes fields, Message& out);
/// The fields before the octets of the records.
[[nodiscard]] bool read_chunk(Bytes fields, Chunk& out, std::size_t& records_at);

/// A whole record in octets that hold records: its opcode and its fields. False at their end, or
/// when the last one is cut.
[[nodiscard]] bool next_record(Bytes& records, Opcode& opcode, Bytes& fields);

}  // namespace romano::experiments::mcap
