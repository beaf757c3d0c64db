#include "overlay/packets_told.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "overlay/waited_for.h"

namespace romano::overlay {
namespace {

constexpr std::size_t most_at_once = 2'000;  // 40,000 octets

std::uint64_t number_of(const protection::SenderId& id) {
    std::uint64_t number = 0;
    for (const std::uint8_t octet : id) number = number << 8U | octet;
    return number;
}

protection::SenderId id_of(std::uint64_t number) {
    protection::SenderId id;
    for (auto octet = id.rbegin(); octet != id.rend(); ++octet) {
        *octet = static_cast<std::uint8_t>(number);
        number >>= 8U;
    }
    return id;
}

}  // namespace

void tell_packets(broker::ProtectedClients& clients, std::vector<cluster::Outgoing>& outgoing) {
    if (std::ranges::none_of(outgoing, is_waited_for)) return;
    const auto heard = clients.to_tell();
    if (heard.empty()) return;
    std::vector<cluster::Outgoing> told;
    for (std::size_t from = 0; from < heard.size(); from += most_at_once) {
        cluster::SecuredTold part;
        const std::size_t end = std::min(from + most_at_once, heard.size());
        for (std::size_t i = from; i < end; ++i) {
            part.packets.push_back({.sender = number_of(heard[i].sender),
                                    .run = static_cast<std::uint32_t>(heard[i].heard.run),
                                    .floor = heard[i].heard.floor});
        }
        told.push_back({std::nullopt, std::move(part)});
    }
    outgoing.insert(outgoing.begin(), std::make_move_iterator(told.begin()),
                    std::make_move_iterator(told.end()));
}

void on_packets_told(const cluster::SecuredTold& told, broker::ProtectedClients& clients) {
    std::vector<broker::PacketsHeard> heard;
    heard.reserve(told.packets.size());
    for (const auto& each : told.packets) {
        heard.push_back({id_of(each.sender), {protection::RunId{each.run}, each.floor}});
    }
    clients.on_told(heard);
}

}  // namespace romano::overlay
