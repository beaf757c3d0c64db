// Plays a recording to the fleet's picture, at any speed, from any place of it. It is told the
// time, and does a bounded part of its work each time, so that whoever shows the picture is not
// held up.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "experiments/fleet/fleet_picture.h"
#include "experiments/mcap/reader.h"

namespace romano::experiments {

class Playback {
public:
    static constexpr double slowest = 0.1;
    static constexpr double fastest = 100;
    /// What was said longer before a place than this is passed over on the way to it: only the
    /// states of brokers and robots count from further back.
    static constexpr std::chrono::seconds remembered{300};

    /// `picture`: is replaced when somebody goes back. It plays from the start.
    Playback(mcap::Reader& reader, std::string file, FleetPicture& picture);

    /// From where it is; at the end, from the start.
    void play();
    void pause();
    /// Kept between slowest and fastest.
    void set_speed(double speed);
    /// To a time of the recording, in milliseconds since 1970.
    void seek(std::uint64_t unix_ms);

    /// Every 50 ms or more often. `now`: of a steady clock.
    void on_tick(Instant now);

private:
    void begin();
    /// False when there is more to tell until `until`, another time.
    bool tell_until(mcap::Timestamp until);
    void tell(const mcap::Reader::Told& told);
    void tick_until(mcap::Timestamp time);
    void show();

    mcap::Reader& reader_;
    std::string file_;
    FleetPicture& picture_;
    std::optional<mcap::Reader::Told> ahead_;  // the next message
    mcap::Timestamp at_ = 0;
    mcap::Timestamp next_tick_ = 0;  // of the picture
    std::optional<mcap::Timestamp> target_;
    std::optional<Instant> last_tick_;
    double speed_ = 1;
    bool is_playing_ = true;
};

}  // namespace romano::experiments
