// Rights drawn from a seed: on which topics each robot may publish and what it may read; and other
// rights, which take their place in the middle of a run, on one broker sooner than on another.
//
// Brokers get them as the text of a rights file (broker/rights). They are judged by the table from
// which that text was written.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "broker/rights/rights.h"
#include "overlay/sim/ledger.h"
#include "romano/base/random.h"
#include "romano/base/time.h"

namespace romano::sim {

class DrawnRights {
public:
    /// Of the robots with these names, on these topics. On all others they may do everything.
    DrawnRights(std::uint64_t seed, std::span<const std::string> robots,
                std::span<const std::string_view> topics);

    struct InForce {
        const broker::Permissions* permissions = nullptr;
        std::string digest;
    };
    /// What a broker is told that starts now.
    [[nodiscard]] InForce in_force() const;
    /// From now on it is the second rights. Brokers that run take them up one after the other.
    void change() { changed_ = true; }
    void on_taken_up(Instant at) { settled_ = at; }

    /// Whatever the moment at which a broker looked at the message.
    [[nodiscard]] bool surely_reads(const std::string& robot, const Sent& message) const;
    [[nodiscard]] bool surely_publishes(const Sent& message) const;
    /// At some moment at which one may have looked.
    [[nodiscard]] bool possibly_reads(const std::string& robot, const Sent& message) const;
    [[nodiscard]] bool possibly_publishes(const Sent& message) const;

private:
    struct Right {
        bool reads = true;
        bool publishes = true;
    };
    struct RobotRights {
        std::string rules;  // its section of the file
        std::map<std::string, Right, std::less<>> on;
    };
    using Table = std::map<std::string, RobotRights, std::less<>>;

    static RobotRights draw(Random& random, const std::string& robot,
                            std::span<const std::string_view> topics);
    [[nodiscard]] static Right find(const Table& table, const std::string& robot,
                                    const std::string& topic);
    [[nodiscard]] bool surely(const std::string& robot, const Sent& message,
                              bool Right::*which) const;
    [[nodiscard]] bool possibly(const std::string& robot, const Sent& message,
                                bool Right::*which) const;

    struct Rules {
        Table table;
        std::string digest;
        std::unique_ptr<rights::Rights> rights;
    };
    std::array<Rules, 2> rules_;  // the first ones, the second ones
    bool changed_ = false;
    std::optional<Instant> settled_;  // the last broker took the second ones up
};

}  // namespace romano::sim
