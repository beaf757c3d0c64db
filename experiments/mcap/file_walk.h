// Goes over an MCAP file from record to record without reading what is in them, and says where it
// ends and whether it was cut there.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "experiments/mcap/records.h"

namespace romano::experiments::mcap {

/// A file's octets, wherever they are.
class OctetSource {
public:
    /// From `offset` on, fewer at the file's end; good until the next call.
    [[nodiscard]] virtual Bytes read(std::uint64_t offset, std::size_t octets) = 0;
    [[nodiscard]] virtual std::uint64_t size() const = 0;

protected:
    ~OctetSource() = default;
};

struct RecordPlace {
    Opcode opcode{};
    std::uint64_t offset = 0;  // of the record, with its head
    std::uint64_t field_octets = 0;

    [[nodiscard]] std::uint64_t fields_at() const { return offset + record_head; }
    [[nodiscard]] std::uint64_t end() const { return fields_at() + field_octets; }
};

class FileWalk {
public:
    explicit FileWalk(OctetSource& file) : file_(file) {}

    /// It begins as an MCAP file does.
    [[nodiscard]] bool begins_well();
    /// Empty at the end, and where the rest is no whole record.
    std::optional<RecordPlace> next();
    /// Behind the last whole record; what comes after it is lost.
    [[nodiscard]] std::uint64_t sound_octets() const { return at_; }
    /// The last record was the one that ends a file, and the end is as it should be.
    [[nodiscard]] bool is_finished();

private:
    OctetSource& file_;
    std::uint64_t at_ = magic.size();
    bool has_footer_ = false;
};

}  // namespace romano::experiments::mcap
