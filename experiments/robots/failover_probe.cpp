#include "experiments/robots/failover_probe.h"

#include <algorithm>
#include <variant>

#include "experiments/robots/stamp.h"
#include "romano/base/random.h"

namespace romano::experiments {

struct FailoverProbe::Pair {
    struct Arrival {
        Instant sent_at;
        Instant at;
    };

    Pair(Surroundings& surroundings, std::size_t broker, const BrokerAddress& address,
         const client::Timing& timing, Random& random, std::optional<std::string>& trouble,
         std::function<void()> on_ring)
        : number(static_cast<std::uint32_t>(broker)),
          topic("probe/" + std::to_string(broker)),
          publisher_id(client_ids_at(broker)[0]),
          subscriber_id(client_ids_at(broker)[1]),
          publisher(
              surroundings, address, timing, random.next(),
              [this, &trouble](const client::Event& event) {
                  if (std::holds_alternative<client::Connected>(event)) {
                      (void)publisher.register_name(topic);
                  } else if (std::holds_alternative<client::Registered>(event)) {
                      can_publish = true;
                  } else {
                      note_trouble(event, trouble);
                  }
              },
              publisher_id),
          subscriber(
              surroundings, address, timing, random.next(),
              [this, &surroundings, &trouble](const client::Event& event) {
                  if (std::holds_alternative<client::Connected>(event)) {
                      (void)subscriber.subscribe(client::topic_name(topic),
                                                 mqttsn::Qos::at_most_once);
                  } else if (std::holds_alternative<client::Subscribed>(event)) {
                      hears = true;
                  } else if (const auto* received = std::get_if<client::Received>(&event)) {
                      const auto stamp = read_stamp(received->data);
                      if (stamp) arrivals.push_back({stamp->sent_at, surroundings.now()});
                  } else {
                      note_trouble(event, trouble);
                  }
              },
              subscriber_id),
          alarm(surroundings.make_alarm(std::move(on_ring))) {}

    static void note_trouble(const client::Event& event, std::optional<std::string>& trouble) {
        if (std::holds_alternative<client::Refused>(event) ||
            std::holds_alternative<client::Failed>(event) ||
            std::holds_alternative<client::Lost>(event)) {
            trouble = "the failover probe was refused, or had no answer from its broker";
        }
    }

    std::uint32_t number;
    std::string topic;
    std::string publisher_id;
    std::string subscriber_id;
    RobotClient publisher;
    RobotClient subscriber;
    std::unique_ptr<Alarm> alarm;
    bool can_publish = false;
    bool hears = false;
    std::uint32_t next_sequence = 0;
    Instant next_publish{};
    std::vector<Arrival> arrivals;
};

FailoverProbe::FailoverProbe(Surroundings& surroundings, const std::vector<BrokerAddress>& brokers,
                             double rate_per_s, Duration retry, std::uint64_t seed)
    : surroundings_(surroundings),
      period_(std::chrono::duration_cast<Duration>(std::chrono::duration<double>{1 / rate_per_s})) {
    client::Timing timing;
    timing.t_retry = retry;
    timing.n_retry =
        std::max(mqttsn::default_n_retry, static_cast<int>(std::chrono::seconds{30} / retry));
    Random random{seed};
    for (std::size_t broker = 0; broker < brokers.size(); ++broker) {
        pairs_.push_back(std::make_unique<Pair>(surroundings, broker, brokers[broker], timing,
                                                random, trouble_, [this, broker] {
                                                    if (publishing_) publish_due(*pairs_[broker]);
                                                }));
    }
}

FailoverProbe::~FailoverProbe() = default;

std::array<std::string, 2> FailoverProbe::client_ids_at(std::size_t broker) {
    const std::string number = std::to_string(broker);
    return {"probe-from-" + number, "probe-to-" + number};
}

void FailoverProbe::join() {
    for (const auto& pair : pairs_) {
        pair->publisher.connect({.client_id = pair->publisher_id, .clean_session = true});
        pair->subscriber.connect({.client_id = pair->subscriber_id, .clean_session = true});
    }
}

bool FailoverProbe::has_joined() const {
    return std::ranges::all_of(pairs_,
                               [](const auto& pair) { return pair->can_publish && pair->hears; });
}

void FailoverProbe::start() {
    publishing_ = true;
    for (const auto& pair : pairs_) {
        pair->next_publish = surroundings_.now();
        schedule(*pair);
    }
}

void FailoverProbe::stop() {
    publishing_ = false;
    for (const auto& pair : pairs_) pair->alarm->set(never);
}

void FailoverProbe::leave() {
    stop();
    for (const auto& pair : pairs_) {
        for (RobotClient* client : {&pair->publisher, &pair->subscriber}) {
            if (client->core().is_connected()) client->disconnect();
        }
    }
}

void FailoverProbe::schedule(Pair& pair) {
    pair.alarm->set(pair.next_publish);
}

void FailoverProbe::publish_due(Pair& pair) {
    const Instant now = surroundings_.now();
    std::vector<std::uint8_t> payload(Stamp::octets);
    write_stamp({pair.number, pair.next_sequence++, now}, payload);
    (void)pair.publisher.publish(client::topic_name(pair.topic), payload,
                                 {.qos = mqttsn::Qos::at_most_once, .retain = false});
    // A moment that was missed is not made up for: what counts is the next one.
    while (pair.next_publish <= now) pair.next_publish += period_;
    schedule(pair);
}

std::optional<Duration> FailoverProbe::failover(std::size_t broker, Instant strike) const {
    std::optional<Duration> first;
    for (const Pair::Arrival& arrival : pairs_[broker]->arrivals) {
        if (arrival.sent_at < strike) continue;
        first = std::min(first.value_or(arrival.at - strike), arrival.at - strike);
    }
    return first;
}

}  // namespace romano::experiments
