#include "experiments/paper/many_cells.h"

#include <chrono>
#include <optional>
#include <stdexcept>
#include <string>

#include "overlay/radio/layout.h"
#include "overlay/radio/radio_network.h"
#include "overlay/sim/cluster_world.h"
#include "overlay/sim/settlement.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using mqttsn::Qos;

constexpr Duration quiet = 5s;  // nothing came for so long: nothing is on its way
constexpr Duration queues_fill = 1s;

std::string name_of(std::size_t robot) {
    return "robot" + std::to_string(robot);
}

sim::ClusterWorldOptions world_options(const ManyCells& cells) {
    sim::ClusterWorldOptions options;
    options.seed = cells.seed;
    options.brokers = cells.brokers;
    options.are_invariants_judged = false;
    options.cluster.beacon_every = 1s;  // profile `mesh`: no broker fails here
    options.cluster.detection_timeout = 6s;
    return options;
}

class CellsOfBrokers {
public:
    explicit CellsOfBrokers(const ManyCells& cells) : world_(world_options(cells)) {
        for (std::size_t i = 0; i < cells.brokers; ++i) {  // the first robots of the world
            sim::RobotOptions on_the_wire;
            on_the_wire.name = "operator" + std::to_string(i);
            on_the_wire.broker = sim::World::service_address(i);
            world_.add_robot(on_the_wire);
        }
        radio::RadioOptions options;
        options.router_baud = cells.router_baud;
        for (std::size_t i = 0; i < cells.brokers; ++i) {
            radio::RadioCell& cell = options.cells.emplace_back();
            cell.channel = lowpan::first_channel + static_cast<unsigned>(i % cells.channels);
            cell.router = radio::place_on_grid(i, cells.brokers, metres_between_routers);
            for (std::size_t j = 0; j < robots_of_a_cell; ++j) add_robot(cell, i, j);
        }
        network_.emplace(world_, options);
        settle();
        learn_topic_ids();
    }

    CellsRun publish(double rate, std::size_t messages) {
        const Instant begin = world_.now();
        for (std::size_t i = 0; i < messages; ++i) {
            publish_to(i);
            const std::chrono::duration<double> due{static_cast<double>(i + 1) / rate};
            world_.run_for(begin + std::chrono::duration_cast<Duration>(due) - world_.now());
        }
        const Instant end = world_.now();
        std::size_t before = 0;
        do {
            before = world_.ledger().receptions.size();
            world_.run_for(quiet);
        } while (world_.ledger().receptions.size() > before);

        CellsRun run{.sent = messages};
        std::size_t while_full = 0;
        for (const sim::Reception& reception : world_.ledger().receptions) {
            if (world_.ledger().sent.at({reception.publisher, reception.number}).at < begin)
                continue;
            ++run.delivered;
            while_full += reception.at >= begin + queues_fill && reception.at < end ? 1U : 0U;
        }
        const std::chrono::duration<double> span = end - begin - queues_fill;
        if (span > 0s) run.delivered_per_s = static_cast<double>(while_full) / span.count();
        return run;
    }

private:
    /// One cell after the other, and their robots in turn.
    void publish_to(std::size_t turn) {
        const std::size_t brokers = world_.broker_count();
        const std::size_t cell = turn % brokers;
        const std::size_t robot = cell * robots_of_a_cell + turn / brokers % robots_of_a_cell;
        const std::size_t from = (cell + brokers - 1) % brokers;
        (void)world_.robot(from).publish(name_of(robot), Qos::at_most_once);
    }

    void add_robot(radio::RadioCell& cell, std::size_t broker, std::size_t number) {
        sim::RobotOptions robot;
        robot.name = name_of(robots_++);
        robot.broker = sim::World::service_address(broker);
        robot.subscriptions = {{robot.name, Qos::at_most_once}};
        const sim::Robot& added = world_.add_robot(robot);
        cell.robots.push_back(
            {added.options().address, radio::place_around(cell.router, number, robots_of_a_cell)});
    }

    void settle() {
        world_.start_brokers();
        if (!world_.run_until([&] { return !sim::disagreement(world_); }, 120s)) {
            throw std::runtime_error("the brokers did not agree within two minutes");
        }
        for (std::size_t i = 0; i < world_.robot_count(); ++i) world_.robot(i).start();
        const auto ready = [&] {
            return world_.robots_are_idle() && world_.ledger().subscriptions.size() == robots_;
        };
        if (!world_.run_until(ready, 120s)) {
            throw std::runtime_error("the robots did not connect within two minutes");
        }
        world_.run_for(5s);  // brokers tell each other of subscriptions
    }

    void learn_topic_ids() {
        for (std::size_t i = 0; i < robots_; ++i) {
            publish_to(i);
            world_.run_for(20ms);
        }
        world_.run_for(quiet);
    }

    std::size_t robots_ = 0;
    sim::ClusterWorld world_;
    std::optional<radio::RadioNetwork> network_;
};

}  // namespace

CellsRun cells_run(const ManyCells& cells, double rate, std::size_t messages) {
    return CellsOfBrokers(cells).publish(rate, messages);
}

}  // namespace romano::experiments
