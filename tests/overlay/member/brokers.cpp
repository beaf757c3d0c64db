#include "tests/overlay/member/brokers.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace romano::test {
namespace {

using namespace std::chrono_literals;

Endpoint endpoint(std::uint8_t net, int host, std::uint16_t port) {
    Endpoint endpoint{};
    endpoint.address = {10, 0, net, static_cast<std::uint8_t>(host)};
    endpoint.port = port;
    endpoint.family = Endpoint::Family::ipv4;
    return endpoint;
}

std::string name_of(int rank) {
    return "b" + std::to_string(rank);
}
broker::BrokerId id_of(int rank) {
    return broker::broker_id_of(name_of(rank));
}

}  // namespace

Endpoint broker_address(int host) {
    return endpoint(0, host, 1883);
}

void Brokers::start(int rank) {
    const Endpoint home = home_of(rank);
    overlay::MemberOptions options;
    options.cluster = options_;
    options.cluster.rank = equal_ ? 0 : static_cast<std::uint32_t>(rank);
    options.name = name_of(rank);
    options.incarnation = ++starts_ * 1000;
    options.home_addresses = {home};
    options.broker.t_retry = 500ms;
    options.broker.advertise_every = Duration::zero();
    options.broker.predefined_topics = predefined_[rank];
    options.uplink = uplink_;
    Running running{.member = std::make_unique<overlay::Member>(options, starts_),
                    .log = {id_of(rank), options.incarnation},
                    .messages = {},
                    .datagrams = {},
                    .unsent = {}};
    running_.insert_or_assign(rank, std::move(running));
    const bool free = cells_ || sockets_[home].empty();
    if (free) bind(rank, home);
    overlay::MemberActions actions;
    running_.at(rank).member->on_address(now_, home, free, actions);
    carry_out(rank, actions);
}

void Brokers::kill(int rank) {
    running_.erase(rank);
    stalled_.erase(rank);
    for (auto& [address, holders] : sockets_) std::erase(holders, rank);
}

void Brokers::wake_slowly(int rank, std::size_t messages_kept) {
    auto& messages = running_.at(rank).messages;
    messages.resize(std::min(messages.size(), messages_kept));
    slow_.insert(rank);
    wake(rank);
}

void Brokers::leave(int rank) {
    overlay::MemberActions actions;
    running_.at(rank).member->leave(now_, actions);
    carry_out(rank, actions);
    kill(rank);
}

Robot& Brokers::robot(const std::string& name, int broker, int site) {
    return place(name, endpoint(1, static_cast<int>(robots_.size()) + 1, 5000), broker, site);
}

Robot& Brokers::robot_beside(const Robot& other, const std::string& name, int broker) {
    return place(name, other.self(), broker, broker);
}

Robot& Brokers::place(const std::string& name, const Endpoint& self, int broker, int site) {
    Placed& placed = robots_.emplace(self, Placed{})->second;
    const auto send = [this, &placed](const Endpoint& from, const Endpoint& to, Bytes octets) {
        const int reached = reached_from(placed.site, to);
        if (reached == 0) return;
        running_.at(reached).datagrams.push_back({to, from, {octets.begin(), octets.end()}});
    };
    placed = {site, std::make_unique<Robot>(name, self, home_of(broker), send)};
    placed.robot->on_tick(now_);
    return *placed.robot;
}

void Brokers::drive(const Robot& robot, int broker) {
    for (auto& [address, placed] : robots_) {
        if (placed.robot.get() == &robot) placed.site = broker;
    }
}

const Brokers::Placed* Brokers::robot_at(const Endpoint& address, const Endpoint& via) const {
    const auto [first, end] = robots_.equal_range(address);
    if (first == end || std::next(first) == end) return first == end ? nullptr : &first->second;
    const Placed* found = nullptr;
    for (auto at = first; at != end; ++at) {
        if (at->second.robot->broker() == via) found = &at->second;
    }
    return found;
}

Endpoint Brokers::home_of(int rank) const {
    return broker_address(cells_ ? 1 : rank);
}

int Brokers::reached_from(int site, const Endpoint& address) const {
    if (cells_) return running_.contains(site) ? site : 0;
    const auto holders = sockets_.find(address);
    if (holders == sockets_.end()) return 0;
    const auto& ranks = holders->second;
    const auto reached = std::find_if(ranks.rbegin(), ranks.rend(), [&](int rank) {
        return !cut_.contains(std::minmax(site, rank));
    });
    return reached == ranks.rend() ? 0 : *reached;
}

void Brokers::run_for(Duration time) {
    for (const Instant end = now_ + time; now_ < end;) step();
}

void Brokers::step() {
    now_ += 1ms;
    for (auto& [address, placed] : robots_) placed.robot->on_tick(now_);
    std::map<int, std::pair<std::deque<overlay::Envelope>, std::deque<Datagram>>> inputs;
    for (auto& [rank, running] : running_) {
        if (stalled_.contains(rank)) continue;
        if (running.unsent && !reads_on_.contains(rank)) {
            running.member->before_sending(now_, *running.unsent);
            carry_out(rank, *running.unsent);
            running.unsent.reset();
        }
        if (running.messages.empty()) slow_.erase(rank);
        auto& [messages, datagrams] = inputs[rank];
        datagrams = std::exchange(running.datagrams, {});
        if (!slow_.contains(rank)) {
            messages = std::exchange(running.messages, {});
        } else if (now_.time_since_epoch() / 1ms % 2 == 0) {
            messages.push_back(std::move(running.messages.front()));
            running.messages.pop_front();
        }
    }
    for (auto& [rank, input] : inputs) {
        overlay::Member& member = *running_.at(rank).member;
        overlay::MemberActions actions;
        if (auto& unsent = running_.at(rank).unsent) {
            actions = *std::exchange(unsent, std::nullopt);
            reads_on_.erase(rank);
        }
        for (const auto& [via, from, octets] : input.second) {
            member.on_datagram(now_, via, from, octets, actions);
        }
        for (const auto& envelope : input.first) member.on_peer_message(now_, envelope, actions);
        if (now_ >= member.next_wakeup()) member.on_tick(now_, actions);
        if (!actions.clients.list().empty() && stalls_before_sending_.erase(rank) > 0) {
            stalled_.insert(rank);
            running_.at(rank).unsent = std::move(actions);
            continue;
        }
        member.before_sending(now_, actions);
        carry_out(rank, actions);
        member.check_invariants();
    }
}

void Brokers::carry_out(int rank, overlay::MemberActions& actions) {
    carry_out_locally(rank, actions);
    Running& self = running_.at(rank);
    for (const auto& outgoing : actions.peers) {
        for (auto& [other, receiver] : running_) {
            if (other == rank || cut_.contains(std::minmax(rank, other))) continue;
            if (outgoing.to && *outgoing.to != id_of(other)) continue;
            receiver.messages.push_back({self.log, outgoing.message});
        }
    }
    for (const auto& action : actions.clients.list()) {
        const auto* send = std::get_if<broker::Send>(&action);
        if (send == nullptr || std::ranges::count(sockets_[send->via], rank) == 0) continue;
        const Placed* placed = robot_at(send->to.endpoint, send->via);
        if (placed == nullptr || cut_.contains(std::minmax(placed->site, rank))) continue;
        if (cells_ && placed->site != rank) continue;
        placed->robot->on_datagram(actions.clients.octets(*send));
    }
    auto& uplink = uplink_actions_[rank];
    uplink.insert(uplink.end(), actions.uplink.begin(), actions.uplink.end());
    actions.clear();
}

void Brokers::read_battery(int rank, std::uint32_t percent) {
    overlay::MemberActions actions;
    running_.at(rank).member->on_condition(now_, percent, actions);
    carry_out(rank, actions);
}

void Brokers::uplink_up(int rank, bool resumed) {
    overlay::MemberActions actions;
    running_.at(rank).member->on_uplink_up(now_, resumed, actions);
    carry_out(rank, actions);
}

void Brokers::uplink_answers(int rank, const broker::LogPosition& position, uplink::Answer answer) {
    overlay::MemberActions actions;
    running_.at(rank).member->on_uplink_answer(now_, position, answer, actions);
    carry_out(rank, actions);
}

void Brokers::uplink_brings(int rank, const uplink::FromRemote& message, std::uint64_t token) {
    overlay::MemberActions actions;
    running_.at(rank).member->on_uplink_message(now_, message, token, actions);
    carry_out(rank, actions);
}

void Brokers::carry_out_locally(int rank, const overlay::MemberActions& actions) {
    for (const auto& action : actions.local) {
        if (const auto* taken = std::get_if<overlay::TakeAddress>(&action)) {
            bind(rank, taken->address);
            overlay::MemberActions answer;
            running_.at(rank).member->on_address(now_, taken->address, true, answer);
            carry_out(rank, answer);
        } else if (const auto* given = std::get_if<overlay::GiveUpAddress>(&action)) {
            std::erase(sockets_[given->address], rank);
        } else if (const auto* notice = std::get_if<overlay::Notice>(&action)) {
            if (notice->is_warning) warnings_[rank].push_back(notice->text);
            if (std::getenv("ROMANO_TRACE") == nullptr) continue;
            std::printf("%lld ms  b%d: %s\n", static_cast<long long>(now_.time_since_epoch() / 1ms),
                        rank, notice->text.c_str());
        }
    }
}

void Brokers::bind(int rank, const Endpoint& address) {
    auto& holders = sockets_[address];
    std::erase(holders, rank);
    holders.push_back(rank);
}

int Brokers::leader_of(int rank) const {
    const auto leader = member(rank).leadership().leader;
    for (const auto& [other, running] : running_) {
        if (leader == election::NodeId{static_cast<std::uint64_t>(id_of(other))}) return other;
    }
    return 0;
}

int Brokers::server_of(int address) const {
    const auto holders = sockets_.find(broker_address(address));
    return holders == sockets_.end() || holders->second.empty() ? 0 : holders->second.back();
}

std::vector<std::string> Brokers::sessions_at(int rank) const {
    std::vector<std::string> clients;
    for (const auto& image : member(rank).broker().images()) {
        clients.push_back(image.header.client_id);
    }
    return clients;
}

}  // namespace romano::test
