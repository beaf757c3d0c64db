#include "overlay/sim/sealed_packets.h"

namespace romano::sim {
namespace {

constexpr std::size_t most_lives = 12;

}  // namespace

protection::RobotKey SealedPackets::key_of(std::string_view robot) {
    return protection::session_key({{0x51}}, robot);
}

std::vector<broker::ProtectedClient> SealedPackets::clients(std::size_t robots) {
    std::vector<broker::ProtectedClient> all;
    for (std::size_t i = 0; i < robots; ++i) {
        std::string name = "robot" + std::to_string(i);
        for (std::size_t life = 0; life < most_lives; ++life, name += '-') {
            all.push_back({name, key_of(name)});
        }
    }
    return all;
}

void SealedPackets::on_sealed(const std::string& robot, Way way, Bytes packet) {
    std::vector<std::uint8_t> copy(packet.begin(), packet.end());
    const auto parsed = protection::parse(copy);
    if (!parsed) return;  // discovery
    const bool is_new = used_.emplace(robot, way, protection::nonce_of(parsed->header)).second;
    if (!is_new) ++repeated_;
}

}  // namespace romano::sim
