#include "broker/core/enforcement.h"

#include <array>
#include <string>
#include <utility>

#include "romano/base/printable.h"

namespace romano::broker {
namespace {

constexpr std::array<const char*, refused_kinds> deeds = {"publish on", "register", "subscribe to",
                                                          "have a will on", "read"};

}  // namespace

void Enforcement::refuse(Refused what, const Speaker& who, std::string_view topic, Turn& turn) {
    tables_.counters.count(what);
    ++untold_;
    notes_.say(turn.now, turn.out, [&] {
        const std::uint64_t others = std::exchange(untold_, 0) - 1;
        return "refused: " + printable(tables_.permissions->name_of(who)) + " may not " +
               deeds[static_cast<std::size_t>(what)] + " '" + printable(topic) + "'" +
               (others == 0 ? ""
                            : "; " + std::to_string(others) + " more since the last such line");
    });
}

}  // namespace romano::broker
