// How far the packets of each protected client were taken, through the end of the broker: a line is
// appended before the first packet of a block has an effect (romano/protection/broker_end.h). The
// file's last word on a client counts.
//
// A killed broker finds all lines; a power cut may cost the last ones, and a stranger could then
// play back what its clients sent in them.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "broker/protection/packets_heard.h"
#include "romano/base/bytes.h"

namespace romano::daemon {

class HeardFile {
public:
    /// Throws keys::KeyError.
    explicit HeardFile(std::filesystem::path file);
    ~HeardFile();
    HeardFile(const HeardFile&) = delete;
    HeardFile& operator=(const HeardFile&) = delete;

    [[nodiscard]] std::optional<protection::Heard> of(const protection::SenderId& sender) const;
    /// False when the file cannot be written.
    [[nodiscard]] bool add(const broker::PacketsHeard& heard);
    /// For an orderly end.
    void add_all(const std::vector<broker::PacketsHeard>& heard);

private:
    void write_anew();
    [[nodiscard]] bool open_again();

    std::filesystem::path path_;
    std::map<protection::SenderId, protection::Heard> heard_;
    std::size_t lines_ = 0;
    int descriptor_ = -1;
};

}  // namespace romano::daemon
