#include "experiments/paper/moves.h"

#include <algorithm>
#include <chrono>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>

#include "overlay/radio/radio_network.h"
#include "overlay/sim/cluster_world.h"
#include "overlay/sim/settlement.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

constexpr std::size_t brokers = 3;
constexpr std::size_t struck = 1;  // the middle one, home of all robots
constexpr std::size_t publisher = 0;
constexpr std::size_t robots = 5;
constexpr double metres_between_routers = 30;
constexpr double metres_per_s = 1;
constexpr Duration publish_every = 50ms;  // to each robot, QoS 0 and 1 in turn
constexpr Duration look_every = 100ms;
constexpr double weight_of_a_look = 0.3;
constexpr double better_by_db = 6;
constexpr Duration lasts = 40s;
constexpr Duration wire_takes = 200us;  // between brokers

std::string name_of(std::size_t robot) {
    return "robot" + std::to_string(robot);
}

sim::ClusterWorldOptions world_options(std::uint64_t seed) {
    sim::ClusterWorldOptions options;
    options.seed = seed;
    options.brokers = brokers;
    options.cluster.beacon_every = 50ms;  // profile `wifi`
    options.cluster.detection_timeout = 500ms;
    // Best-effort messages that overtake each other are dropped: this wire keeps their order.
    options.peers.quality = {.delay_min = wire_takes, .delay_max = wire_takes};
    return options;
}

class Field {
public:
    explicit Field(std::uint64_t seed) : world_(world_options(seed)) {
        sim::RobotOptions on_the_wire;
        on_the_wire.name = "operator";
        world_.add_robot(on_the_wire);
        radio::RadioOptions options;
        options.router_baud = 230'400;
        options.cells.resize(brokers);
        for (std::size_t i = 0; i < robots; ++i) {
            sim::RobotOptions robot;
            robot.name = name_of(i);
            robot.broker = sim::World::service_address(struck);
            robot.subscriptions = {{robot.name, Qos::at_least_once}};
            robot.topics = {"pose/" + robot.name};
            robot.qos = {Qos::at_most_once};
            robot.publish_every_min = 150ms;
            robot.publish_every_max = 250ms;
            world_.add_robot(robot);
            places_.push_back({metres_between_routers * struck, 1 + static_cast<double>(i)});
        }
        for (std::size_t cell = 0; cell < brokers; ++cell) {
            options.cells[cell].channel = lowpan::first_channel + 5 * static_cast<unsigned>(cell);
            options.cells[cell].router = {metres_between_routers * static_cast<double>(cell), 0};
            for (std::size_t i = 0; i < robots; ++i) {
                options.cells[cell].robots.push_back({address_of(i), places_[i]});
            }
        }
        network_.emplace(world_, options);
        for (std::size_t i = 0; i < robots; ++i) network_->join(address_of(i), struck);
        settle();
    }

    MovesRun run(Change change) {
        begun_ = world_.now();
        if (change == Change::broker_dies || change == Change::machine_dies) {
            world_.broker(struck).crash();
        }
        if (change == Change::machine_dies) network_->switch_off_router(struck);
        for (std::size_t turn = 0; world_.now() < begun_ + lasts; ++turn) {
            if (change == Change::robots_leave) drive();
            if (turn * publish_every % look_every == 0ms) {
                for (std::size_t i = 0; i < robots; ++i) look(i);
            }
            for (std::size_t i = 0; i < robots; ++i) {
                (void)world_.robot(publisher).publish(
                    name_of(i), (turn + i) % 2 == 0 ? Qos::at_most_once : Qos::at_least_once);
                world_.run_for(publish_every / robots);
            }
        }
        ended_ = world_.now();
        world_.run_for(20s);
        return figures();
    }

private:
    static std::size_t index_of(std::size_t robot) { return publisher + 1 + robot; }
    [[nodiscard]] const Endpoint& address_of(std::size_t robot) {
        return world_.robot(index_of(robot)).options().address;
    }

    void settle() {
        world_.start_brokers();
        if (!world_.run_until([&] { return !sim::disagreement(world_); }, 60s)) {
            throw std::runtime_error("the brokers did not agree within a minute");
        }
        for (std::size_t i = 0; i < world_.robot_count(); ++i) world_.robot(i).start();
        const auto ready = [&] {
            return world_.robots_are_idle() && world_.ledger().subscriptions.size() == robots;
        };
        if (!world_.run_until(ready, 60s)) {
            throw std::runtime_error("the robots did not connect within a minute");
        }
        for (std::size_t i = 0; i < robots; ++i) {
            world_.robot(index_of(i)).begin_publishing();
            (void)world_.robot(publisher).publish(name_of(i), Qos::at_most_once);
        }
        Random random(world_.seed());
        world_.run_for(5s + random.between(0s, 1s));  // strikes at any time of a beacon
    }

    void drive() {
        const std::chrono::duration<double> step = publish_every;
        for (std::size_t i = 0; i < robots; ++i) {
            double& x = places_[i].x_m;
            x = std::min(x + metres_per_s * step.count(),
                         metres_between_routers * static_cast<double>(brokers - 1));
            network_->move(address_of(i), places_[i]);
        }
    }

    /// What a robot does that hears several routers: it joins one that is clearly stronger.
    void look(std::size_t robot) {
        auto& heard = heard_[robot];
        for (std::size_t cell = 0; cell < brokers; ++cell) {
            const double now = network_->hears_dbm(address_of(robot), cell);
            const auto [mean, is_first] = heard.emplace(cell, now);
            if (!is_first) mean->second += weight_of_a_look * (now - mean->second);
        }
        const auto best = std::ranges::max_element(
            heard, {}, [](const auto& cell_and_dbm) { return cell_and_dbm.second; });
        std::size_t& joined = joined_.try_emplace(robot, struck).first->second;
        if (best->second < heard.at(joined) + better_by_db) return;
        joined = best->first;
        ++joins_;
        network_->join(address_of(robot), joined);
        world_.robot(index_of(robot)).roam_to(sim::World::service_address(joined));
    }

    [[nodiscard]] MovesRun figures() {
        MovesRun run{.joins = joins_};
        std::map<std::string, std::set<std::uint32_t>> got;
        std::map<std::string, Instant> last;
        std::map<std::string, Duration> silence;
        for (const sim::Reception& reception : world_.ledger().receptions) {
            const std::string& robot = reception.subscriber;
            got[robot].insert(reception.number);
            if (reception.at < begun_ || reception.at > ended_) continue;
            Instant& before = last.try_emplace(robot, begun_).first->second;
            silence[robot] = std::max(silence[robot], reception.at - before);
            before = reception.at;
        }
        for (std::size_t i = 0; i < robots; ++i) {
            const std::string robot = name_of(i);
            const Instant before = last.try_emplace(robot, begun_).first->second;
            silence[robot] = std::max(silence[robot], ended_ - before);
            run.silence_ms.push_back(
                std::chrono::duration<double, std::milli>(silence[robot]).count());
            run.reconnects += world_.robot(index_of(i)).connects() - 1;
        }
        for (const auto& [key, sent] : world_.ledger().sent) {
            if (sent.publisher != "operator" || sent.at < begun_) continue;
            const bool is_lost = !got[sent.topic].contains(sent.number);
            const bool is_qos0 = sent.qos == Qos::at_most_once;
            ++(is_qos0 ? run.sent_qos0 : run.sent_qos1);
            if (is_lost) ++(is_qos0 ? run.lost_qos0 : run.lost_qos1);
        }
        return run;
    }

    sim::ClusterWorld world_;
    std::optional<radio::RadioNetwork> network_;
    std::vector<radio::Place> places_;
    std::map<std::size_t, std::map<std::size_t, double>> heard_;  // by robot and cell
    std::map<std::size_t, std::size_t> joined_;
    std::size_t joins_ = 0;
    Instant begun_{};
    Instant ended_{};
};

}  // namespace

MovesRun moves_run(Change change, std::uint64_t seed) {
    return Field(seed).run(change);
}

}  // namespace romano::experiments
