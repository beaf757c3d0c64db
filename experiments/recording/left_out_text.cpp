#include "experiments/recording/left_out_text.h"

#include <array>
#include <cstdio>
#include <ctime>

namespace romano::experiments {

std::string utc_text(mcap::Timestamp time) {
    constexpr mcap::Timestamp second = 1'000'000'000;
    const auto seconds = static_cast<std::time_t>(time / second);
    std::tm parts{};
    ::gmtime_r(&seconds, &parts);
    std::array<char, 64> day{};
    (void)std::strftime(day.data(), day.size(), "%Y-%m-%d %H:%M:%S", &parts);
    std::array<char, 96> text{};
    (void)std::snprintf(text.data(), text.size(), "%s.%03u UTC", day.data(),
                        static_cast<unsigned>(time % second / 1'000'000));
    return text.data();
}

std::vector<std::string> sentences_about(const mcap::Reader& reader) {
    std::vector<std::string> out;
    const mcap::LeftOut& left_out = reader.left_out();
    const auto tell = [&out](std::uint64_t count, const std::string& words) {
        if (count > 0) out.push_back(std::to_string(count) + ' ' + words);
    };
    if (!reader.is_finished()) {
        const std::string lost = reader.end() == 0
                                     ? "it holds no whole chunk of messages"
                                     : "what came after " + utc_text(reader.end()) + " is lost";
        out.push_back("the recording was not ended: " + lost + " (" +
                      std::to_string(left_out.octets_cut) +
                      " octets at the end are no whole record)");
    }
    tell(left_out.chunks_damaged, "chunks are damaged and left out");
    tell(left_out.chunks_too_large, "chunks are larger than 64 MiB and left out");
    tell(left_out.chunks_too_many, "chunks are more than can be kept in mind, and left out");
    tell(left_out.messages_outside, "messages stand outside of chunks and are left out");
    tell(left_out.messages_unknown, "messages belong to no channel and are left out");
    if (left_out.chunks_compressed > 0) {
        std::string names;
        for (const std::string& name : left_out.compressions) {
            names += (names.empty() ? "" : ", ") + name;
        }
        out.push_back(std::to_string(left_out.chunks_compressed) + " chunks are compressed with " +
                      names +
                      " and left out: zstd and none can be read (mcap compress "
                      "--compression zstd)");
    }
    return out;
}

}  // namespace romano::experiments
