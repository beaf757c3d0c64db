#include "experiments/mcap/records.h"

#include <algorithm>

namespace romano::experiments::mcap {
namespace {

void append_number(Octets& out, std::uint64_t value, std::size_t octets) {
    for (std::size_t i = 0; i < octets; ++i, value >>= 8U) {
        out.push_back(static_cast<std::uint8_t>(value));
    }
}

}  // namespace

std::string_view Channel::metadata_of(std::string_view name) const {
    for (const auto& [key, value] : metadata) {
        if (key == name) return value;
    }
    return {};
}

RecordWriter::RecordWriter(Octets& out, Opcode opcode) : out_(out) {
    out_.push_back(static_cast<std::uint8_t>(opcode));
    append_number(out_, 0, 8);
    begin_ = out_.size();
}

RecordWriter::~RecordWriter() {
    std::uint64_t length = out_.size() - begin_;
    for (std::size_t at = begin_ - 8; at < begin_; ++at, length >>= 8U) {
        out_[at] = static_cast<std::uint8_t>(length);
    }
}

RecordWriter& RecordWriter::u16(std::uint16_t value) {
    append_number(out_, value, 2);
    return *this;
}

RecordWriter& RecordWriter::u32(std::uint32_t value) {
    append_number(out_, value, 4);
    return *this;
}

RecordWriter& RecordWriter::u64(std::uint64_t value) {
    append_number(out_, value, 8);
    return *this;
}

RecordWriter& RecordWriter::octets(Bytes value) {
    out_.insert(out_.end(), value.begin(), value.end());
    return *this;
}

RecordWriter& RecordWriter::text(std::string_view value) {
    return list(value.size()).octets(as_octets(value));
}

RecordWriter& RecordWriter::list(std::size_t octet_count) {
    return u32(static_cast<std::uint32_t>(octet_count));
}

void write_header(Octets& out, std::string_view library) {
    constexpr std::string_view no_profile;
    RecordWriter{out, Opcode::header}.text(no_profile).text(library);
}

void write_schema(Octets& out, const Schema& schema) {
    RecordWriter{out, Opcode::schema}
        .u16(schema.id)
        .text(schema.name)
        .text(schema.encoding)
        .text(schema.data);
}

void write_channel(Octets& out, const Channel& channel) {
    std::size_t metadata_octets = 0;
    for (const auto& [key, value] : channel.metadata) {
        metadata_octets += 8 + key.size() + value.size();
    }
    RecordWriter record{out, Opcode::channel};
    record.u16(channel.id)
        .u16(channel.schema_id)
        .text(channel.topic)
        .text(channel.message_encoding)
        .list(metadata_octets);
    for (const auto& [key, value] : channel.metadata) record.text(key).text(value);
}

void write_message(Octets& out, const Message& message) {
    RecordWriter{out, Opcode::message}
        .u16(message.channel_id)
        .u32(message.sequence)
        .u64(message.log_time)
        .u64(message.publish_time)
        .octets(message.data);
}

void write_chunk(Octets& out, const Chunk& chunk, Bytes records) {
    RecordWriter{out, Opcode::chunk}
        .u64(chunk.start)
        .u64(chunk.end)
        .u64(chunk.uncompressed_octets)
        .u32(chunk.uncompressed_crc)
        .text(chunk.compression)
        .u64(records.size())
        .octets(records);
}

void write_data_end(Octets& out) {
    constexpr std::uint32_t no_crc = 0;  // each chunk has its own
    RecordWriter{out, Opcode::data_end}.u32(no_crc);
}

Bytes FieldReader::take(std::uint64_t octets) {
    if (octets > rest_.size()) {
        has_all_ = false;
        rest_ = {};
        return {};
    }
    const Bytes taken = rest_.first(static_cast<std::size_t>(octets));
    rest_ = rest_.subspan(taken.size());
    return taken;
}

std::uint64_t FieldReader::number(std::size_t octets) {
    const Bytes field = take(octets);
    std::uint64_t value = 0;
    for (std::size_t at = field.size(); at > 0; --at) value = value << 8U | field[at - 1];
    return value;
}

Bytes FieldReader::list() {
    const std::uint32_t octets = u32();
    return take(octets);
}

std::string_view FieldReader::text() {
    return as_text(list());
}

bool read_channel(Bytes fields, Channel& out) {
    FieldReader reader{fields};
    out.id = reader.u16();
    out.schema_id = reader.u16();
    out.topic = reader.text();
    out.message_encoding = reader.text();
    FieldReader metadata{reader.list()};
    out.metadata.clear();
    while (metadata.has_all() && !metadata.rest().empty()) {
        const std::string_view key = metadata.text();
        out.metadata.emplace_back(key, metadata.text());
    }
    return reader.has_all() && metadata.has_all();
}

bool read_message(Bytes fields, Message& out) {
    FieldReader reader{fields};
    out.channel_id = reader.u16();
    out.sequence = reader.u32();
    out.log_time = reader.u64();
    out.publish_time = reader.u64();
    out.data = reader.rest();
    return reader.has_all();
}

bool read_chunk(Bytes fields, Chunk& out, std::size_t& records_at) {
    FieldReader reader{fields};
    out.start = reader.u64();
    out.end = reader.u64();
    out.uncompressed_octets = reader.u64();
    out.uncompressed_crc = reader.u32();
    out.compression = reader.text();
    out.record_octets = reader.u64();
    records_at = fields.size() - reader.rest().size();
    return reader.has_all();
}

bool next_record(Bytes& records, Opcode& opcode, Bytes& fields) {
    if (records.size() < record_head) return false;
    FieldReader length{records.subspan(1, 8)};
    const std::uint64_t octets = length.u64();
    if (octets > records.size() - record_head) return false;
    opcode = static_cast<Opcode>(records[0]);
    fields = records.subspan(record_head, static_cast<std::size_t>(octets));
    records = records.subspan(record_head + fields.size());
    return true;
}

}  // namespace romano::experiments::mcap
