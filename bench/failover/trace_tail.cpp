#include "bench/failover/trace_tail.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <iterator>

namespace romano::bench {

TraceLine parse_trace_line(std::string_view line) {
    const auto open = line.find('[');
    const auto close = line.find("] ", open);
    const auto colon = line.find(": ", close);
    if (open == line.npos || close == line.npos || colon == line.npos)
        return {{}, std::string(line)};
    double seconds = 0;
    const char* end = line.data() + close;
    const auto [stop, error] = std::from_chars(line.data() + open + 1, end, seconds);
    if (error != std::errc{} || stop != end) return {{}, std::string(line)};
    const std::chrono::duration<double> since_boot{seconds};
    return {Instant{std::chrono::duration_cast<Duration>(since_boot)},
            std::string(line.substr(colon + 2))};
}

void TraceTail::read() {
    std::ifstream stream(file_);
    stream.seekg(offset_);
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    std::size_t begin = 0;
    for (std::size_t end = text.find('\n'); end != text.npos; end = text.find('\n', begin)) {
        lines_.push_back(parse_trace_line(std::string_view(text).substr(begin, end - begin)));
        begin = end + 1;
    }
    offset_ += static_cast<std::streamoff>(begin);
}

std::filesystem::path TraceTail::earlier_lives() const {
    return file_.parent_path() / (file_.stem().string() + "-earlier-lives.txt");
}

void TraceTail::restart() {
    if (std::ifstream before(file_); before.peek() != std::ifstream::traits_type::eof()) {
        std::ofstream(earlier_lives(), std::ios::app) << before.rdbuf();
    }
    offset_ = 0;
    lines_.clear();
}

const TraceLine* TraceTail::find(std::string_view beginning, Instant since) const {
    const auto found = std::ranges::find_if(lines_, [&](const TraceLine& line) {
        return line.at && *line.at >= since && line.text.starts_with(beginning);
    });
    return found == lines_.end() ? nullptr : &*found;
}

const TraceLine* TraceTail::last(std::string_view beginning) const {
    const auto found = std::find_if(lines_.rbegin(), lines_.rend(), [&](const TraceLine& line) {
        return line.text.starts_with(beginning);
    });
    return found == lines_.rend() ? nullptr : &*found;
}

}  // namespace romano::bench
