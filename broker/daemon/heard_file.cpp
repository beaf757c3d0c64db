#include "broker/daemon/heard_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <sstream>
#include <string>
#include <utility>

#include "romano/keys/key_error.h"
#include "romano/keys/private_file.h"

namespace romano::daemon {
namespace {

// Where the lines are so many more than the clients, they are written anew.
constexpr std::size_t lines_a_client = 4;
constexpr std::size_t fewest_lines = 1'000;

std::string line_of(const protection::SenderId& sender, const protection::Heard& heard) {
    std::string line;
    std::array<char, 32> part{};
    for (const std::uint8_t octet : sender) {
        std::snprintf(part.data(), part.size(), "%02x", octet);
        line += part.data();
    }
    std::snprintf(part.data(), part.size(), " %u %u.\n", static_cast<std::uint32_t>(heard.run),
                  heard.floor);
    return line + part.data();
}

/// The dot tells a whole line from what a full disk left of one.
std::optional<broker::PacketsHeard> parse(const std::string& line) {
    broker::PacketsHeard heard;
    unsigned long long sender = 0;
    std::uint32_t run = 0;
    int end = 0;
    if (std::sscanf(line.c_str(), "%16llx %10u %10u.%n", &sender, &run, &heard.heard.floor, &end) !=
            3 ||
        static_cast<std::size_t>(end) != line.size()) {
        return std::nullopt;
    }
    for (std::size_t i = 0; i < heard.sender.size(); ++i) {
        heard.sender[i] = static_cast<std::uint8_t>(sender >> (56 - 8 * i));
    }
    heard.heard.run = protection::RunId{run};
    return heard;
}

}  // namespace

HeardFile::HeardFile(std::filesystem::path file) : path_(std::move(file)) {
    if (std::filesystem::exists(path_)) {
        std::istringstream text(keys::read_private_file(path_));
        for (std::string line; std::getline(text, line);) {
            if (const auto heard = parse(line))
                heard_.insert_or_assign(heard->sender, heard->heard);
        }
    }
    write_anew();
}

HeardFile::~HeardFile() {
    if (descriptor_ >= 0) close(descriptor_);
}

void HeardFile::write_anew() {
    std::string text;
    for (const auto& [sender, heard] : heard_) text += line_of(sender, heard);
    lines_ = heard_.size();  // also when it fails: tried again as many lines later
    try {
        keys::write_private_file(path_, text);
    } catch (const keys::KeyError&) {
        (void)open_again();  // the new file may be there, and only its folder not be safe
        throw;
    }
    if (!open_again()) {
        throw keys::KeyError(path_.string() + ": cannot be written (" + std::strerror(errno) + ")");
    }
}

bool HeardFile::open_again() {
    if (descriptor_ >= 0) close(descriptor_);
    descriptor_ = open(path_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
    return descriptor_ >= 0;
}

std::optional<protection::Heard> HeardFile::of(const protection::SenderId& sender) const {
    const auto found = heard_.find(sender);
    return found == heard_.end() ? std::nullopt : std::optional{found->second};
}

bool HeardFile::add(const broker::PacketsHeard& heard) {
    if (descriptor_ < 0 && !open_again()) return false;
    const std::string line = line_of(heard.sender, heard.heard);
    if (write(descriptor_, line.data(), line.size()) != static_cast<ssize_t>(line.size())) {
        // What there is of the line is closed by an end, and says nothing.
        (void)!write(descriptor_, "\n", 1);
        return false;
    }
    heard_.insert_or_assign(heard.sender, heard.heard);
    if (++lines_ <= fewest_lines + lines_a_client * heard_.size()) return true;
    try {
        write_anew();
    } catch (const keys::KeyError&) {  // the longer file says the same
    }
    return true;
}

void HeardFile::add_all(const std::vector<broker::PacketsHeard>& all) {
    for (const auto& heard : all) heard_.insert_or_assign(heard.sender, heard.heard);
    write_anew();
}

}  // namespace romano::daemon
