// MCAP files in memory, for tests.
#pragma once

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "experiments/mcap/chunk_writer.h"
#include "experiments/mcap/file_walk.h"
#include "experiments/mcap/reader.h"
#include "experiments/mcap/summary.h"

namespace romano::experiments::mcap {

struct FileInMemory final : OctetSource {
    Octets octets;

    [[nodiscard]] Bytes read(std::uint64_t offset, std::size_t size) override {
        const auto at = static_cast<std::size_t>(std::min<std::uint64_t>(offset, octets.size()));
        return Bytes{octets}.subspan(at, std::min(size, octets.size() - at));
    }
    [[nodiscard]] std::uint64_t size() const override { return octets.size(); }

    void append(Bytes more) { octets.insert(octets.end(), more.begin(), more.end()); }
    void finish() {
        (void)append_summary(*this, [this](Bytes part) {
            append(part);
            return true;
        });
    }
};

inline ChunkWriter a_writer() {
    return ChunkWriter{{.id = 1, .name = "test", .encoding = "jsonschema", .data = "{}"}, "json"};
}

/// `chunks` of ten messages each, a second apart: message n on topic t<n modulo 3> says n.
inline FileInMemory a_file(int chunks, bool is_finished = true) {
    FileInMemory file;
    ChunkWriter writer = a_writer();
    file.append(writer.beginning("test"));
    int number = 0;
    for (int chunk = 0; chunk < chunks; ++chunk) {
        for (int i = 0; i < 10; ++i, ++number) {
            const std::string text = std::to_string(number);
            const auto time = Timestamp{1'000'000'000} * static_cast<Timestamp>(number + 1);
            (void)writer.add(time, "t" + std::to_string(number % 3), "name", as_octets(text));
        }
        file.append(writer.take_chunk());
    }
    if (is_finished) file.finish();
    return file;
}

/// All that a reader tells from where it is, as texts.
inline std::vector<std::string> texts_in(Reader& reader) {
    std::vector<std::string> texts;
    while (const auto told = reader.next()) texts.emplace_back(as_text(told->data));
    return texts;
}

}  // namespace romano::experiments::mcap
