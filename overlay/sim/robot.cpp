#include "overlay/sim/robot.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <variant>

#include "overlay/sim/seed.h"
#include "romano/mqttsn/cell.h"

namespace romano::sim {

using mqttsn::Qos;

namespace {
template <typename... Fs>
struct Overloaded : Fs... {
    using Fs::operator()...;
};
template <typename... Fs>
Overloaded(Fs...) -> Overloaded<Fs...>;

const std::string will_of(const RobotOptions& options) {
    return options.will_topic ? will_payload(options.name) : std::string{};
}

constexpr std::uint32_t moves_ppm = 50'000;  // with a Connection ID, before it publishes

}  // namespace

Robot::Robot(const RobotOptions& options, EventQueue& events, ClientNetwork& network, Trace& trace,
             Ledger& ledger, std::uint64_t seed)
    : options_(options),
      events_(events),
      network_(network),
      trace_(trace),
      ledger_(ledger),
      random_(seed_of(seed, "application")),
      client_(options.timing, seed_of(seed, "client")),
      protection_(options.sealed != nullptr ? std::make_unique<Protection>(options.name) : nullptr),
      moves_(seed_of(seed, "moves")),
      will_(will_of(options)) {
    if (options.dtls == nullptr) return;
    dtls_.emplace(options.name, options.has_id, *options.dtls, seed_of(seed, "handshakes"));
}

Robot::~Robot() {
    if (!on_) return;
    network_.unbind(binding_);
    if (listens()) network_.leave(options_.cell_group, options_.address);
}

void Robot::start() {
    on_ = true;
    bind();
    if (listens()) network_.join(options_.cell_group, options_.address);
    connect(options_.clean_session);
}

void Robot::bind() {
    binding_ = network_.bind(
        options_.address, options_.node,
        [this](const Endpoint&, const Endpoint&, Bytes datagram) { on_datagram(datagram); },
        [this](const Endpoint& from) { return from == options_.broker; });
}

void Robot::connect(bool clean) {
    ++connects_;
    connecting_since_ = events_.now();
    trace_.note(events_.now(), options_.name, clean ? "connects anew" : "connects");
    client::ConnectOptions connect{
        .client_id = options_.name, .clean_session = clean, .keep_alive = options_.keep_alive};
    if (options_.will_topic) {
        connect.will = client::Will{
            .topic = *options_.will_topic, .message = as_octets(will_), .qos = Qos::exactly_once};
    }
    client_.connect(events_.now(), connect, out_);
    drain();
}

void Robot::switch_off() {
    if (!on_) return;
    trace_.note(events_.now(), options_.name, "is switched off");
    on_ = false;
    publishing_ = false;
    network_.unbind(binding_);
    if (listens()) network_.leave(options_.cell_group, options_.address);
    end_spans(nullptr);
    ledger_.silenced.emplace(options_.name, events_.now());
}

void Robot::roam_to(const Endpoint& broker) {
    trace_.note(events_.now(), options_.name, "roams to", broker);
    options_.broker = broker;
    if (!dtls_) return;
    dtls_->on_other_broker();
    if (dtls_->has_id()) change_address();
}

/// As by a NAT.
void Robot::change_address() {
    network_.unbind(binding_);
    ++options_.address.port;
    bind();
    options_.dtls->on_moved();
}

void Robot::fall_asleep(std::chrono::seconds duration) {
    if (!client_.is_connected()) return;
    trace_.note(events_.now(), options_.name, "falls asleep");
    client_.sleep(events_.now(), duration, out_);
    drain();
}

void Robot::come_back() {
    if (is_sleeping()) connect(false);
}

bool Robot::is_sleeping() const {
    return client_.state() == client::State::falling_asleep ||
           client_.state() == client::State::asleep || client_.state() == client::State::awake;
}

void Robot::end_spans(const std::string* filter) {
    for (SubscriptionSpan& span : ledger_.subscriptions) {
        if (span.subscriber != options_.name || span.until) continue;
        if (filter == nullptr || span.filter == *filter) span.until = events_.now();
    }
}

void Robot::subscribe(const std::string& filter, Qos qos) {
    end_spans(&filter);
    const auto operation = client_.subscribe(events_.now(), client::topic_name(filter), qos, out_);
    if (operation) asked_.insert_or_assign(*operation, Subscribing{filter});
    drain();
}

/// In each connection anew. The ledger has no such topic: nothing comes on it.
void Robot::listen() {
    (void)client_.subscribe(events_.now(), client::topic_name(mqttsn::cell_topic),
                            Qos::at_most_once, out_);
    drain();
}

void Robot::unsubscribe(const std::string& filter) {
    end_spans(&filter);
    (void)client_.unsubscribe(events_.now(), client::topic_name(filter), out_);
    drain();
}

void Robot::begin_publishing() {
    if (std::exchange(publishing_, true) || options_.topics.empty()) return;
    publish_next();
}

void Robot::end_publishing() {
    publishing_ = false;
}

void Robot::publish_next() {
    const Duration pause = random_.between(options_.publish_every_min, options_.publish_every_max);
    events_.after(pause, [this] {
        if (!publishing_) return;
        const auto pick = [this](const auto& choices) {
            return choices[random_.below(static_cast<std::uint32_t>(choices.size()))];
        };
        const std::string topic = pick(options_.topics);
        const Qos qos = pick(options_.qos);
        const bool retain = random_.happens(options_.retain_ppm);
        if (dtls_ && dtls_->has_id() && moves_.happens(moves_ppm)) change_address();
        if (!is_sleeping()) (void)publish(topic, qos, retain);
        publish_next();
    });
}

std::optional<std::uint32_t> Robot::publish(const std::string& topic, Qos qos, bool retain) {
    if (!on_) return std::nullopt;
    const std::uint32_t number = last_number_ + 1;
    const std::string payload = to_payload(options_.name, number);
    const auto operation =
        client_.publish(events_.now(), client::topic_name(topic), as_octets(payload),
                        {.qos = qos, .retain = retain}, out_);
    if (operation) {
        last_number_ = number;
        asked_.insert_or_assign(*operation, number);
        ledger_.sent.emplace(std::pair{options_.name, number}, Sent{.publisher = options_.name,
                                                                    .number = number,
                                                                    .topic = topic,
                                                                    .qos = qos,
                                                                    .retain = retain,
                                                                    .at = events_.now(),
                                                                    .acknowledged = std::nullopt});
        trace_.note(events_.now(), options_.name, "publishes", number, "qos", qos, topic);
    }
    drain();
    if (!operation) return std::nullopt;
    return number;
}

std::vector<std::uint8_t> Robot::seal(Bytes message) {
    auto& [keys, end, skipped] = *protection_;
    if (skipped.is_due(message)) end.skip_block();
    if (const auto bound = end.reserve().to_store()) end.reserve().on_stored(*bound);
    std::vector<std::uint8_t> packet(message.size() + protection::most_overhead);
    packet.resize(end.seal(message, packet));
    options_.sealed->on_sealed(options_.name, SealedPackets::Way::to_broker, packet);
    return packet;
}

void Robot::on_datagram(Bytes datagram) {
    std::vector<std::uint8_t> packet;
    if (protection_) {
        packet.assign(datagram.begin(), datagram.end());
        datagram = protection_->end.open(packet);
        if (datagram.empty()) return;
        protection_->skipped.on_heard();
    }
    if (dtls_) {
        datagram = dtls_->open(datagram, [this](Bytes out) { put(out); });
        if (datagram.empty()) return;
    }
    client_.on_datagram(events_.now(), datagram, out_);
    drain();
}

void Robot::on_timer() {
    if (!on_) return;
    client_.on_tick(events_.now(), out_);
    drain();
}

void Robot::rearm() {
    const Instant wanted = std::max(client_.next_wakeup(), events_.now());
    if (wanted == never || wanted >= timer_) return;
    timer_ = wanted;
    events_.at(wanted, [this, wanted] {
        if (timer_ != wanted) return;
        timer_ = never;
        on_timer();
    });
}

void Robot::drain() {
    for (const Bytes datagram : out_.datagrams()) {
        if (protection_) {
            put(seal(datagram));
        } else if (dtls_) {
            dtls_->send(datagram, [this](Bytes out) { put(out); });
        } else {
            put(datagram);
        }
    }
    // Events are handled after the fact: what they make the application ask for needs out_ again.
    const std::vector<client::Event> events(out_.events().begin(), out_.events().end());
    out_.clear();
    for (const client::Event& event : events) on_event(event);
    rearm();
}

void Robot::on_event(const client::Event& event) {
    std::visit(
        Overloaded{
            [this](const client::Connected&) {
                trace_.note(events_.now(), options_.name, "is connected");
                if (options_.will_topic) {
                    ledger_.will_topics.emplace(options_.name, *options_.will_topic);
                }
                // One that called for long in vain may have been given up meanwhile.
                if (events_.now() > connecting_since_ + options_.timing.t_retry) lapse();
                for (const SubscriptionSpan& lapsed : std::exchange(lapsed_, {})) {
                    ledger_.subscriptions.push_back(lapsed);
                    ledger_.subscriptions.back().from = events_.now();
                }
                if (listens()) listen();
                if (std::exchange(subscribed_, true)) return;
                for (const auto& [filter, qos] : options_.subscriptions) subscribe(filter, qos);
            },
            [this](const client::Refused&) { connect_again(); },
            [this](const client::Lost&) { connect_again(); },
            [this](const client::Disconnected&) { connect_again(); },
            [this](const client::Received& received) { on_received(received); },
            [this](const client::Published& published) { on_published(published.operation, true); },
            [this](const client::Failed& failed) { on_published(failed.operation, false); },
            [this](const client::Subscribed& subscribed) { on_subscribed(subscribed); },
            [](const auto&) {},
        },
        event);
}

void Robot::connect_again() {
    trace_.note(events_.now(), options_.name, "has lost its broker");
    if (std::exchange(reconnect_pending_, true)) return;
    lapse();
    events_.after(random_.between(std::chrono::milliseconds{10}, std::chrono::milliseconds{200}),
                  [this] {
                      reconnect_pending_ = false;
                      if (on_) connect(false);
                  });
}

/// A clean session has a right to nothing between the end of its connection and the next one.
void Robot::lapse() {
    if (!options_.clean_session) return;
    std::ranges::copy_if(ledger_.subscriptions, std::back_inserter(lapsed_),
                         [this](const SubscriptionSpan& span) {
                             return span.subscriber == options_.name && !span.until;
                         });
    end_spans(nullptr);
}

void Robot::on_published(client::OperationId operation, bool accepted) {
    const auto found = asked_.find(operation);
    if (found == asked_.end()) return;
    if (const auto* number = std::get_if<std::uint32_t>(&found->second)) {
        Sent& sent = ledger_.sent.at({options_.name, *number});
        if (accepted) {
            sent.acknowledged = events_.now();
        } else {
            sent.refused = true;
        }
        trace_.note(events_.now(), options_.name, accepted ? "acknowledged" : "refused", *number);
    }
    asked_.erase(found);
}

void Robot::on_subscribed(const client::Subscribed& subscribed) {
    const auto found = asked_.find(subscribed.operation);
    if (found == asked_.end()) return;
    const std::string filter = std::get<Subscribing>(found->second).filter;
    asked_.erase(found);
    trace_.note(events_.now(), options_.name, "subscribed", filter);
    ledger_.subscriptions.push_back({.subscriber = options_.name,
                                     .filter = filter,
                                     .granted = subscribed.granted,
                                     .from = events_.now(),
                                     .until = std::nullopt});
}

void Robot::on_received(const client::Received& received) {
    const std::string payload{as_text(received.data)};
    if (const auto robot = from_will_payload(payload)) {
        trace_.note(events_.now(), options_.name, "receives the will of", *robot);
        ledger_.wills.push_back({.subscriber = options_.name,
                                 .of = *robot,
                                 .at = events_.now(),
                                 .qos = received.qos,
                                 .retain = received.retain});
        return;
    }
    const auto message = from_payload(payload);
    if (!message) return;  // $SYS
    trace_.note(events_.now(), options_.name, "receives", message->first, message->second, "qos",
                received.qos);
    ledger_.receptions.push_back({.subscriber = options_.name,
                                  .publisher = message->first,
                                  .number = message->second,
                                  .qos = received.qos,
                                  .retain = received.retain,
                                  .dup = received.dup,
                                  .at = events_.now()});
}

}  // namespace romano::sim
