#include "experiments/robots/swarm.h"

#include <algorithm>
#include <utility>

#include "experiments/robots/stamp.h"
#include "romano/base/random.h"

namespace romano::experiments {
namespace {

constexpr std::size_t joining_at_once = 32;

double in_seconds(Duration duration) {
    return std::chrono::duration<double>(duration).count();
}

}  // namespace

struct Swarm::Robot {
    Robot(Surroundings& surroundings, RobotNumber own_number, const BrokerAddress& broker,
          const client::Timing& timing, std::uint64_t seed, RobotClient::OnEvent on_event,
          std::function<void()> on_ring)
        : number(own_number),
          client_id(client_id_of(own_number)),
          client(surroundings, broker, timing, seed, std::move(on_event), client_id),
          alarm(surroundings.make_alarm(std::move(on_ring))) {}

    RobotNumber number;
    std::string client_id;
    RobotClient client;
    std::unique_ptr<Alarm> alarm;

    std::vector<const TrafficTopic*> to_subscribe;
    std::vector<const TrafficTopic*> to_register;
    std::size_t set_up = 0;  // of both, in order
    bool joined = false;

    Instant next_publish{};
    std::uint32_t next_sequence = 0;
    std::unordered_map<std::uint16_t, std::uint32_t> open;  // operation → sequence, QoS 1 and 2
    std::vector<std::uint8_t> payload;
};

Swarm::Swarm(Surroundings& robots, Surroundings& server, std::vector<BrokerAddress> brokers,
             Traffic traffic, const SwarmOptions& options)
    : surroundings_(robots),
      brokers_(std::move(brokers)),
      traffic_(std::move(traffic)),
      options_(options) {
    // A client of a dead broker must outlast the failover: it keeps trying for half a minute.
    client::Timing timing;
    timing.t_retry = options_.retry;
    timing.n_retry = std::max(mqttsn::default_n_retry,
                              static_cast<int>(std::chrono::seconds{30} / options_.retry));
    Random random{options_.seed};
    for (RobotNumber number = 0; number < traffic_.clients(); ++number) {
        robots_.push_back(std::make_unique<Robot>(
            traffic_.is_robot(number) ? robots : server, number, brokers_[number % brokers_.size()],
            timing, random.next(),
            [this, number](const client::Event& event) { on_event(*robots_[number], event); },
            [this, number] {
                if (loading_) publish_due(*robots_[number]);
            }));
        Robot& robot = *robots_.back();
        robot.payload.assign(options_.payload_octets, 0);
        robot.to_subscribe = traffic_.heard_by(number);
        robot.to_register = traffic_.published_by(number);
    }
}

Swarm::~Swarm() = default;

std::string Swarm::client_id_of(RobotNumber number) {
    return "robot-" + std::to_string(number);
}

void Swarm::join() {
    for (std::size_t i = 0; i < joining_at_once; ++i) join_next();
}

void Swarm::join_next() {
    if (next_to_join_ == robots_.size()) return;
    Robot& robot = *robots_[next_to_join_++];
    robot.client.connect({.client_id = robot.client_id, .clean_session = true});
}

void Swarm::advance_joining(Robot& robot) {
    const std::size_t at = robot.set_up++;
    if (at < robot.to_subscribe.size()) {
        // At QoS 2 every message is delivered at the level it was published at.
        (void)robot.client.subscribe(client::topic_name(robot.to_subscribe[at]->name),
                                     mqttsn::Qos::exactly_once);
    } else if (at < robot.to_subscribe.size() + robot.to_register.size()) {
        (void)robot.client.register_name(robot.to_register[at - robot.to_subscribe.size()]->name);
    } else {
        robot.joined = true;
        ++joined_;
        join_next();
    }
}

void Swarm::start_load() {
    loading_ = true;
    started_ = surroundings_.now();
    // Everybody begins at another moment within his first period: no bursts that nobody asked for.
    Random random{options_.seed + 1};
    for (const auto& robot : robots_) {
        if (!traffic_.publishes(robot->number)) continue;
        const auto period = std::chrono::duration_cast<Duration>(
            std::chrono::duration<double>{1 / options_.rate_per_s});
        robot->next_publish = started_ + random.between(Duration{}, period);
        schedule(*robot);
    }
}

void Swarm::stop_load() {
    // What is due and was not handed over by now counts as late, too.
    for (const auto& robot : robots_) {
        robot->alarm->set(never);
        if (!loading_ || !traffic_.publishes(robot->number)) continue;
        worst_lag_ = std::max(worst_lag_, surroundings_.now() - robot->next_publish);
    }
    loading_ = false;
}

void Swarm::leave() {
    stop_load();
    for (const auto& robot : robots_) {
        if (robot->client.core().is_connected()) robot->client.disconnect();
    }
}

void Swarm::schedule(Robot& robot) {
    robot.alarm->set(robot.next_publish);
}

void Swarm::publish_due(Robot& robot) {
    const auto period = std::chrono::duration_cast<Duration>(
        std::chrono::duration<double>{1 / options_.rate_per_s});
    const Instant now = surroundings_.now();
    while (robot.next_publish <= now) {
        worst_lag_ = std::max(worst_lag_, now - robot.next_publish);
        publish_one(robot);
        robot.next_publish += period;
    }
    schedule(robot);
}

void Swarm::publish_one(Robot& robot) {
    const Instant now = surroundings_.now();
    const Traffic::Step step = traffic_.step(robot.number, robot.next_sequence);
    write_stamp({robot.number, robot.next_sequence, now}, robot.payload);
    const auto begun =
        robot.client.publish(client::topic_name(step.topic.name), robot.payload,
                             {.qos = static_cast<mqttsn::Qos>(step.qos), .retain = false});
    if (!begun) {
        ++refused_;
        return;
    }
    ++robot.next_sequence;
    const std::uint32_t sequence = account_.on_published(robot.number, step.topic.stream, step.qos,
                                                         seconds_at(now), step.topic.subscribers);
    if (step.qos > 0) robot.open[static_cast<std::uint16_t>(*begun)] = sequence;
}

void Swarm::on_event(Robot& robot, const client::Event& event) {
    if (const auto* received = std::get_if<client::Received>(&event)) {
        const auto stamp = read_stamp(received->data);
        if (!stamp) return;
        account_.on_arrived(stamp->publisher, stamp->sequence, robot.number,
                            seconds_at(surroundings_.now()));
    } else if (const auto* published = std::get_if<client::Published>(&event)) {
        const auto operation = robot.open.find(static_cast<std::uint16_t>(published->operation));
        if (operation == robot.open.end()) return;
        account_.on_acknowledged(robot.number, operation->second, seconds_at(surroundings_.now()));
        robot.open.erase(operation);
    } else if (std::holds_alternative<client::Connected>(event) ||
               std::holds_alternative<client::Subscribed>(event) ||
               std::holds_alternative<client::Registered>(event)) {
        if (!robot.joined) advance_joining(robot);
    } else if (const auto* refused = std::get_if<client::Refused>(&event)) {
        trouble_ = robot.client_id + " was refused with return code " +
                   std::to_string(static_cast<int>(refused->return_code));
    } else if (const auto* failed = std::get_if<client::Failed>(&event)) {
        robot.open.erase(static_cast<std::uint16_t>(failed->operation));
        if (!robot.joined) {
            trouble_ = robot.client_id + "'s subscription or registration was refused";
        }
    } else if (std::holds_alternative<client::Lost>(event)) {
        ++lost_clients_;
        trouble_ = robot.client_id + " had no answer from its broker";
    } else if (const auto* disconnected = std::get_if<client::Disconnected>(&event)) {
        if (!disconnected->by_broker) return;
        ++lost_clients_;
        trouble_ = robot.client_id + " was disconnected by its broker";
    }
}

double Swarm::seconds_at(Instant at) const {
    return in_seconds(at - started_);
}

std::vector<RobotNumber> Swarm::clients_of(std::size_t broker) const {
    std::vector<RobotNumber> clients;
    for (std::size_t i = broker; i < robots_.size(); i += brokers_.size()) {
        clients.push_back(static_cast<RobotNumber>(i));
    }
    return clients;
}

std::uint64_t Swarm::sent(mqttsn::MsgType type) const {
    std::uint64_t sum = 0;
    for (const auto& robot : robots_) sum += robot->client.sent().of(type);
    return sum;
}

}  // namespace romano::experiments
