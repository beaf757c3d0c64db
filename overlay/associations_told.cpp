#include "overlay/associations_told.h"

#include <algorithm>
#include <cstdint>
#include <iterator>
#include <utility>

#include "overlay/waited_for.h"

namespace romano::overlay {
namespace {

constexpr std::size_t most_at_once = 400;  // 60,000 octets

cluster::AssociationOfClient to_message(const dtls::AssociationTold& told) {
    cluster::AssociationOfClient out{.id = static_cast<std::uint64_t>(told.id),
                                     .client = told.client_id,
                                     .via = told.path.via,
                                     .from = told.path.from,
                                     .keys = {told.keys.begin(), told.keys.end()},
                                     .turn = told.progress.turn.value,
                                     .floor = told.progress.floor,
                                     .roaming = {}};
    if (told.roaming) {
        const Bytes id = told.roaming->id.octets();
        out.roaming = {{id.begin(), id.end()}, told.roaming->at};
    }
    return out;
}

cluster::ProgressOfAssociation to_message(const dtls::ProgressTold& told) {
    return {.id = static_cast<std::uint64_t>(told.id),
            .turn = told.progress.turn.value,
            .floor = told.progress.floor,
            .closed = told.is_closed};
}

/// In messages of at most so many.
template <typename In, typename Field>
void add(const std::vector<In>& told, Field field, std::vector<cluster::Outgoing>& out) {
    for (std::size_t from = 0; from < told.size(); from += most_at_once) {
        cluster::SecuredTold part;
        const std::size_t end = std::min(from + most_at_once, told.size());
        for (std::size_t i = from; i < end; ++i) (part.*field).push_back(to_message(told[i]));
        out.push_back({std::nullopt, std::move(part)});
    }
}

}  // namespace

void tell_associations(dtls::DtlsClients& clients, std::vector<cluster::Outgoing>& outgoing) {
    if (!clients.has_news() && std::ranges::none_of(outgoing, is_waited_for)) return;
    const dtls::Told told = clients.to_tell();
    if (told.empty()) return;
    std::vector<cluster::Outgoing> first;
    add(told.associations, &cluster::SecuredTold::associations, first);
    add(told.progress, &cluster::SecuredTold::progress, first);
    outgoing.insert(outgoing.begin(), std::make_move_iterator(first.begin()),
                    std::make_move_iterator(first.end()));
}

void on_associations_told(const cluster::SecuredTold& told, dtls::DtlsClients& clients) {
    dtls::Told out;
    for (const auto& each : told.associations) {
        if (each.keys.size() != dtls::wrapped_octets) continue;
        dtls::AssociationTold one{.id = dtls::AssociationId{each.id},
                                  .client_id = each.client,
                                  .path = {each.via, each.from},
                                  .keys = {},
                                  .progress = {dtls::Turn{each.turn}, each.floor},
                                  .roaming = {}};
        if (each.roaming) {
            const auto id = dtls::ConnectionId::of(each.roaming->id);
            if (!id) continue;
            one.roaming = {*id, each.roaming->at};
        }
        std::ranges::copy(each.keys, one.keys.begin());
        out.associations.push_back(std::move(one));
    }
    for (const auto& each : told.progress) {
        out.progress.push_back(
            {dtls::AssociationId{each.id}, {dtls::Turn{each.turn}, each.floor}, each.closed});
    }
    clients.on_told(out);
}

}  // namespace romano::overlay
