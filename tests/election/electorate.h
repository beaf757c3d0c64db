// Several electors in one room: beacons, ballots, suspicions and time, by hand. Who hears whom is a
// test's choice.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <utility>
#include <vector>

#include "election/elector.h"
#include "romano/base/random.h"

namespace romano::election {

/// The rules' clock: a beacon every 10 ms, silence is noticed after 50 ms.
inline constexpr Duration beacon_every = std::chrono::milliseconds{10};
inline constexpr Duration detection_time = std::chrono::milliseconds{50};

class Electorate {
public:
    using Make = std::function<std::unique_ptr<Elector>(const ElectorOptions&)>;

    /// Nodes 1 to `count`; a higher number is a higher rank.
    Electorate(std::size_t count, std::uint64_t seed, Make make)
        : random_(seed), make_(std::move(make)) {
        for (std::size_t i = 1; i <= count; ++i) voters_.push_back(NodeId{i});
        for (const NodeId node : voters_) start(node);
    }

    void start(NodeId node) {
        ElectorOptions options;
        options.self = rank_of(node);
        options.detection_time = detection_time;
        options.listens_alone_for = detection_time;
        options.voters = voters_;
        options.seed = random_.next();
        nodes_[node] = {make_(options), {}};
    }
    void crash(NodeId node) { nodes_.erase(node); }

    /// Only nodes of one group hear each other.
    void partition(std::vector<std::set<NodeId>> groups) { groups_ = std::move(groups); }
    void heal() { groups_.clear(); }
    void lose(std::uint32_t parts_per_million) { loss_ = parts_per_million; }

    void run_for(Duration time) {
        const Instant end = now_ + time;
        while (now_ < end) {
            now_ += std::chrono::milliseconds{1};
            step();
        }
    }

    [[nodiscard]] Instant now() const { return now_; }
    [[nodiscard]] Elector& node(NodeId id) { return *nodes_.at(id).elector; }
    [[nodiscard]] Leadership leadership(NodeId id) { return node(id).leadership(); }
    [[nodiscard]] const std::map<Term, std::set<NodeId>>& leaders_by_term() const {
        return leaders_by_term_;
    }

    /// True when all of `members` follow `leader`, in one term.
    [[nodiscard]] bool follow(const std::set<NodeId>& members, NodeId leader) {
        const Leadership expected = leadership(leader);
        if (expected.leader != leader) return false;
        for (const NodeId member : members) {
            if (leadership(member) != expected) return false;
        }
        return true;
    }

private:
    struct Node {
        std::unique_ptr<Elector> elector;
        std::map<NodeId, Instant> last_heard;
    };
    struct Letter {
        Instant due;
        NodeId from;
        NodeId to;
        Ballot ballot;
    };

    static Rank rank_of(NodeId node) { return {static_cast<std::uint32_t>(node), 0, node}; }

    [[nodiscard]] bool connected(NodeId a, NodeId b) const {
        if (groups_.empty()) return true;
        for (const auto& group : groups_) {
            if (group.contains(a) && group.contains(b)) return true;
        }
        return false;
    }

    void step() {
        deliver_letters();
        if (now_.time_since_epoch() % beacon_every == Duration{0}) deliver_beacons();
        for (auto& [id, node] : nodes_) {
            suspect_the_silent(node);
            if (node.elector->next_wakeup() <= now_) node.elector->on_tick(now_);
            collect(id, node);
            const Leadership leadership = node.elector->leadership();
            if (leadership.leader == id) leaders_by_term_[leadership.term].insert(id);
        }
    }

    void deliver_beacons() {
        for (auto& [from, sender] : nodes_) {
            for (auto& [to, receiver] : nodes_) {
                if (from == to || !connected(from, to) || random_.happens(loss_)) continue;
                receiver.last_heard[from] = now_;
                receiver.elector->on_claim(now_, sender.elector->claim());
            }
        }
    }

    void suspect_the_silent(Node& node) {
        std::erase_if(node.last_heard, [&](const auto& peer) {
            if (now_ - peer.second <= detection_time) return false;
            node.elector->on_suspect(now_, peer.first);
            return true;
        });
    }

    void collect(NodeId id, Node& node) {
        for (const BallotTo& letter : node.elector->take_ballots()) {
            const Duration delay = random_.between(Duration{0}, std::chrono::milliseconds{3});
            letters_.push_back({now_ + delay, id, letter.to, letter.ballot});
        }
    }

    void deliver_letters() {
        std::deque<Letter> waiting = std::exchange(letters_, {});
        for (const Letter& letter : waiting) {
            if (letter.due > now_) {
                letters_.push_back(letter);
                continue;
            }
            const auto receiver = nodes_.find(letter.to);
            if (receiver == nodes_.end() || !connected(letter.from, letter.to)) continue;
            receiver->second.elector->on_ballot(now_, letter.from, letter.ballot);
        }
    }

    Random random_;
    Make make_;
    Instant now_{};
    std::vector<NodeId> voters_;
    std::map<NodeId, Node> nodes_;
    std::vector<std::set<NodeId>> groups_;
    std::uint32_t loss_ = 0;
    std::deque<Letter> letters_;
    std::map<Term, std::set<NodeId>> leaders_by_term_;
};

}  // namespace romano::election
