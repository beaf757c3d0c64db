#include "romano/protection/robot_end.h"

namespace romano::protection {

Bytes RobotEnd::open(MutableBytes datagram) {
    const auto packet = parse(datagram);
    if (!packet) return refuse(packet.error());
    const Fields fields = packet->fields();
    if (fields.number >= max_number) return refuse(Refusal::malformed);
    if (fields.run != run_) return refuse(Refusal::other_run);
    const std::size_t place = place_of(fields.sender);
    if (place < known_ && brokers_[place].window.has_seen(fields.number)) {
        return refuse(Refusal::replayed);
    }
    if (!protection::open(*packet, to_robot_)) return refuse(Refusal::bad_tag);
    note(place, fields);
    return packet->message();
}

Bytes RobotEnd::refuse(Refusal why) {
    refusals_.count(why);
    return {};
}

/// The number of known brokers when it is none of them.
std::size_t RobotEnd::place_of(const SenderId& id) const {
    std::size_t place = 0;
    while (place < known_ && brokers_[place].id != id) ++place;
    return place;
}

/// The broker at `place`, or a new one, comes to the front.
void RobotEnd::note(std::size_t place, const Fields& fields) {
    ReplayWindow window;
    if (place < known_) {
        window = brokers_[place].window;
    } else if (known_ < brokers) {
        ++known_;
    } else {  // the packets of who is forgotten are of another run from now on
        --place;
        run_ = RunId{sealer_.next()};
    }
    for (; place != 0; --place) brokers_[place] = brokers_[place - 1];
    window.note(fields.number);
    brokers_[0] = {fields.sender, window};
}

}  // namespace romano::protection
