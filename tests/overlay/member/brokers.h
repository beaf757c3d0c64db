// Members wired together in virtual time, a millisecond a step: every message takes one step, and
// arrives unless a test cut the link. Service addresses are those of one host: the newest socket of
// an address gets its datagrams. A robot stands beside the broker that it began with: a cut that
// parts brokers parts their robots as well.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "overlay/member/member.h"
#include "tests/overlay/member/robot.h"

namespace romano::test {

/// 10.0.0.<host>:1883
[[nodiscard]] Endpoint broker_address(int host);

class Brokers {
public:
    explicit Brokers(cluster::ClusterOptions options = {}) : options_(std::move(options)) {}

    /// Broker `rank` is named "b<rank>" and serves broker_address(rank).
    void start(int rank);
    void kill(int rank);
    void leave(int rank);
    void stall(int rank) { stalled_.insert(rank); }
    /// As soon as it has something to say to a client, and before that is said.
    void stall_before_sending(int rank) { stalls_before_sending_.insert(rank); }
    /// The same in the middle of what came together: what came meanwhile is read first.
    void stall_before_reading_on(int rank) {
        stall_before_sending(rank);
        reads_on_.insert(rank);
    }
    void wake(int rank) { stalled_.erase(rank); }
    /// Of what came meanwhile only the first messages were kept; they are read one every 2 ms.
    void wake_slowly(int rank, std::size_t messages_kept);
    void cut(int a, int b) { cut_.insert(std::minmax(a, b)); }
    void heal() { cut_.clear(); }

    void heal(int a, int b) { cut_.erase(std::minmax(a, b)); }

    Robot& robot(const std::string& name, int broker) { return robot(name, broker, broker); }
    /// It stands somewhere else: what parts `site` from a broker parts the robot from it.
    Robot& robot(const std::string& name, int broker, int site);
    /// Has the same address: behind a NAT that keeps source ports, which knows who talks to which
    /// broker, or at the port of one that is no more; then the newer one gets what comes there.
    Robot& robot_beside(const Robot& other, const std::string& name, int broker);

    /// Brokers that are started from now on serve one address, each in its own cell: a robot
    /// reaches the broker that it stands beside.
    void serve_one_address_in_every_cell() { cells_ = true; }
    /// Broker `rank` knows these topics when it is started.
    void predefine(int rank, std::map<mqttsn::TopicId, std::string> topics) {
        predefined_[rank] = std::move(topics);
    }
    /// Warnings of broker `rank` so far.
    [[nodiscard]] const std::vector<std::string>& warnings(int rank) { return warnings_[rank]; }
    /// All brokers that are started from now on have one capability.
    void make_equally_capable() { equal_ = true; }
    /// Broker `rank` reads this of its battery.
    void read_battery(int rank, std::uint32_t percent);
    /// Its machine would not serve that address.
    void forbid(int rank, int address) {
        running_.at(rank).member->on_ability(broker_address(address), false);
    }
    /// The robot drives there.
    void drive(const Robot& robot, int broker);

    // --- the uplink of brokers that are started from now on
    void give_uplink(uplink::UplinkOptions options) { uplink_ = std::move(options); }
    /// What a broker wanted of its uplink so far.
    [[nodiscard]] const std::vector<uplink::UplinkAction>& uplink_actions(int rank) {
        return uplink_actions_[rank];
    }
    void uplink_up(int rank, bool resumed);
    void uplink_answers(int rank, const broker::LogPosition& position, uplink::Answer answer);
    void uplink_brings(int rank, const uplink::FromRemote& message, std::uint64_t token);

    void run_for(Duration time);

    [[nodiscard]] const overlay::Member& member(int rank) const {
        return *running_.at(rank).member;
    }
    [[nodiscard]] int leader_of(int rank) const;
    [[nodiscard]] std::size_t view_size(int rank) const {
        return member(rank).view().members.size();
    }
    /// Who gets the datagrams for that address; 0: nobody.
    [[nodiscard]] int server_of(int address) const;
    [[nodiscard]] std::vector<std::string> sessions_at(int rank) const;

private:
    struct Datagram {
        Endpoint via;
        Endpoint from;
        std::vector<std::uint8_t> octets;
    };
    struct Running {
        std::unique_ptr<overlay::Member> member;
        broker::LogId log;
        std::deque<overlay::Envelope> messages;
        std::deque<Datagram> datagrams;
        std::optional<overlay::MemberActions> unsent;  // while it stands still
    };

    void step();
    void carry_out(int rank, overlay::MemberActions& actions);
    void carry_out_locally(int rank, const overlay::MemberActions& actions);
    [[nodiscard]] Endpoint home_of(int rank) const;
    /// The newest socket of the address that a robot beside `site` reaches; 0: none.
    [[nodiscard]] int reached_from(int site, const Endpoint& address) const;
    void bind(int rank, const Endpoint& address);

    cluster::ClusterOptions options_;
    bool cells_ = false;
    bool equal_ = false;
    std::map<int, std::map<mqttsn::TopicId, std::string>> predefined_;
    std::map<int, std::vector<std::string>> warnings_;
    std::optional<uplink::UplinkOptions> uplink_;
    std::map<int, std::vector<uplink::UplinkAction>> uplink_actions_;
    Instant now_ = Instant{} + std::chrono::seconds{1};
    std::uint64_t starts_ = 0;
    std::map<int, Running> running_;
    std::set<int> stalled_;
    std::set<int> stalls_before_sending_;
    std::set<int> reads_on_;  // before it sends
    std::set<int> slow_;
    std::set<std::pair<int, int>> cut_;
    std::map<Endpoint, std::vector<int>> sockets_;  // the last one is the newest
    struct Placed {
        int site = 0;
        std::unique_ptr<Robot> robot;
    };
    Robot& place(const std::string& name, const Endpoint& self, int broker, int site);
    [[nodiscard]] const Placed* robot_at(const Endpoint& address, const Endpoint& via) const;
    std::multimap<Endpoint, Placed> robots_;
};

}  // namespace romano::test
