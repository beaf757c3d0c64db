#include "experiments/mcap/compression.h"

#include <zlib.h>
#include <zstd.h>

namespace romano::experiments::mcap {

std::uint32_t crc32_of(Bytes octets, std::uint32_t before) {
    return static_cast<std::uint32_t>(::crc32_z(before, octets.data(), octets.size()));
}

Octets compressed_with_zstd(Bytes records) {
    constexpr int quick = 1;
    Octets out(ZSTD_compressBound(records.size()));
    const std::size_t size =
        ZSTD_compress(out.data(), out.size(), records.data(), records.size(), quick);
    out.resize(ZSTD_isError(size) != 0 ? 0 : size);  // an error: there is no memory for it
    return out;
}

std::optional<Octets> uncompressed(std::string_view compression, Bytes records, std::size_t size) {
    if (compression.empty()) {
        if (records.size() != size) return std::nullopt;
        return Octets{records.begin(), records.end()};
    }
    if (compression != zstd) return std::nullopt;
    Octets out(size);
    const std::size_t got = ZSTD_decompress(out.data(), out.size(), records.data(), records.size());
    if (ZSTD_isError(got) != 0 || got != size) return std::nullopt;
    return out;
}

}  // namespace romano::experiments::mcap
