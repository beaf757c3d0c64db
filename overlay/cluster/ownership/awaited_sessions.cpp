#include "overlay/cluster/ownership/awaited_sessions.h"

#include <utility>

#include "romano/mqttsn/topic.h"

namespace romano::cluster {
namespace {

constexpr std::size_t topics_most = 20'000;  // who wants others comes in its turn

}  // namespace

void AwaitedSessions::list(const broker::SessionImage& session) {
    if (session.header.state != broker::SessionState::active) return;  // it waits for nothing
    const broker::ClientId& client = session.header.client_id;
    bool is_awaited = !session.deliveries.empty();
    for (const broker::Subscription& subscription : session.subscriptions) {
        const std::string& filter = subscription.filter;
        const bool wants_any = mqttsn::has_wildcard(filter);
        is_awaited = is_awaited || (wants_any ? !topics_.empty() : topics_.contains(filter));
        if (!is_awaited) (wants_any ? of_any_ : of_topic_[filter]).push_back(client);
    }
    if (is_awaited) awaited_.insert(client);
}

void AwaitedSessions::on_publish(std::string_view topic) {
    if (topics_.size() == topics_most) return;
    const auto [name, is_new] = topics_.emplace(topic);
    if (!is_new) return;
    for (auto& client : std::exchange(of_any_, {})) awaited_.insert(std::move(client));
    auto wanted = of_topic_.extract(*name);
    if (wanted.empty()) return;
    for (auto& client : wanted.mapped()) awaited_.insert(std::move(client));
}

std::vector<broker::ClientId> AwaitedSessions::take(std::size_t most) {
    Clients taken;
    while (!awaited_.empty() && taken.size() < most) {
        taken.push_back(std::move(awaited_.extract(awaited_.begin()).value()));
    }
    return taken;
}

}  // namespace romano::cluster
