#include "overlay/dds/dds_transport.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <string_view>

#include "overlay/dds/make_room.h"

namespace romano::dds {
namespace {

constexpr std::chrono::milliseconds drained_for{1};

constexpr const char* beacon_topic = "romano_beacon";
constexpr const char* log_topic = "romano_log";

// Deep enough for every beacon of a large cluster while the reader is paused for a second.
Qos beacon_qos() {
    return best_effort(1024);
}

// What is not acknowledged waits here; a peer that stands still is let go after the lease (1 s).
Qos log_qos() {
    return reliable(20'000);
}

/// Whatever else came from the network is not shown to people.
bool looks_like_a_version(const std::string& text) {
    constexpr std::string_view letters = "0123456789.abcdefghijklmnopqrstuvwxyz~+-";
    return !text.empty() && text.size() <= 32 &&
           text.find_first_not_of(letters) == std::string::npos;
}

}  // namespace

DdsTransport::DdsTransport(boost::asio::io_context& io, const Domain& domain,
                           const broker::LogId& self, const overlay::Pulses& pulses,
                           std::function<void()> on_drained, LaterLife::OnKnown on_later_life)
    : self_(self),
      on_drained_(std::move(on_drained)),
      wakeup_(std::make_shared<Wakeup>(io, [this] { drain(); })),
      participant_(domain.make_participant()),
      beacons_(participant_, beacon_topic, beacon_qos(), self, pulses),
      log_(participant_, log_topic, log_qos(), self) {
    if (on_later_life) later_life_.emplace(io, participant_, self, std::move(on_later_life));
}

DdsTransport::~DdsTransport() = default;

void DdsTransport::start(Receiver receiver) {
    receiver_ = std::move(receiver);
    const auto read = [this](const std::string& topic, const Qos& qos, auto heed) {
        readers_.push_back(
            {std::make_unique<SampleReader>(participant_, topic, qos, wakeup_), heed});
    };
    read(inbox_topic(self_), inbox_qos(), &DdsTransport::on_inbox_sample);
    read(beacon_topic, beacon_qos(), &DdsTransport::on_sample);
    read(log_topic, log_qos(), &DdsTransport::on_sample);
    read(forward_topic(self_), forward_qos(), &DdsTransport::on_sample);
}

void DdsTransport::send(const overlay::Outgoing& outgoing) {
    if (delivery_of(outgoing.message) == cluster::Delivery::beacon) {
        return send_beacon(outgoing.message);
    }
    const Bytes body = codec_.encode(outgoing.message);
    if (!outgoing.to) return send_to_all(outgoing.message, body);
    const auto at = peers_.find(*outgoing.to);
    if (at == peers_.end()) {
        ++counters_.unknown_peer;
        return;
    }
    send_to(at->second, delivery_of(outgoing.message), body);
}

void DdsTransport::send_beacon(const cluster::ClusterMessage& message) {
    const auto pulse = cluster::pulse_after(message);
    const Bytes pulse_body = pulse ? codec_.encode(*pulse) : Bytes{};
    pulse_.assign(pulse_body.begin(), pulse_body.end());
    const Bytes body = codec_.encode(message);
    count_written(beacons_.send(body, pulse_), body);
}

void DdsTransport::send_to_all(const cluster::ClusterMessage& message, Bytes body) {
    const auto delivery = delivery_of(message);
    if (delivery == cluster::Delivery::log) return count_written(log_.write(body), body);
    for (auto& [id, peer] : peers_) send_to(peer, delivery, body);
}

void DdsTransport::send_to(Peer& peer, cluster::Delivery delivery, Bytes body) {
    const bool may_be_lost = delivery == cluster::Delivery::best_effort;
    SampleWriter& writer = may_be_lost ? peer.writers.forwards : peer.writers.inbox;
    count_written(writer.write(body), body);
}

void DdsTransport::count_written(bool written, Bytes body) {
    if (!written) {
        ++counters_.write_failed;
        return;
    }
    ++counters_.sent;
    counters_.sent_octets += body.size();
}

/// All readers in turn, until they are empty or it takes long: the rest in another turn of the
/// thread, so that clients are not kept waiting.
void DdsTransport::drain() {
    using Clock = std::chrono::steady_clock;
    drained_at_ = Clock::now();
    const auto until = drained_at_ + drained_for;
    std::size_t empty = 0;  // so many in a row
    while (empty < readers_.size() && (empty > 0 || Clock::now() < until)) {
        const Reading& reading = readers_[next_reader_];
        next_reader_ = (next_reader_ + 1) % readers_.size();
        const std::size_t count = reading.reader->take(
            [&](const SampleView& sample) { (this->*reading.on_sample)(sample); });
        empty = count < SampleReader::most_at_once ? empty + 1 : 0;
    }
    if (on_drained_) on_drained_();
    if (empty < readers_.size()) wakeup_->ring();
}

void DdsTransport::on_inbox_sample(const SampleView& sample) {
    Peer* peer = peer_of(sample.from);
    if (peer == nullptr) return;
    // After a lost and found link DDS brings the last ones again.
    if (sample.number <= peer->last_inbox_number) {
        ++counters_.repeated;
        return;
    }
    peer->last_inbox_number = sample.number;
    on_sample(sample);
}

void DdsTransport::on_sample(const SampleView& sample) {
    if (sample.from == self_) return;
    auto message = codec_.decode(sample.body);
    if (!message) return refuse(sample);
    if (peer_of(sample.from) == nullptr) return;
    ++counters_.received;
    counters_.received_octets += sample.body.size();
    receiver_({sample.from, std::move(*message)});
}

void DdsTransport::refuse(const SampleView& sample) {
    const auto version = codec_.version_of_other_protocol(sample.body);
    if (!version) {
        ++counters_.malformed;
        return;
    }
    ++counters_.other_protocol;
    if (looks_like_a_version(*version)) tell_of_other_version(sample.from.broker, *version);
}

void DdsTransport::tell_of_other_version(const broker::BrokerId& broker,
                                         const std::string& version) {
    if (told_of_.size() == most_peers || !told_of_.insert(broker).second) return;
    spdlog::warn(
        "a broker of version {} is in this DDS domain, and this one of version " ROMANO_VERSION
        " does not understand it: they form no cluster until both are of one version",
        version);
}

DdsTransport::Peer* DdsTransport::peer_of(const broker::LogId& log) {
    const auto at = peers_.find(log.broker);
    if (at != peers_.end()) {
        const auto known = at->second.writers.addressee.incarnation;
        if (known == log.incarnation) {
            at->second.heard_at = drained_at_;
            return &at->second;
        }
        if (known > log.incarnation) return nullptr;  // words of a broker that was restarted since
        peers_.erase(at);
    } else if (!make_room(peers_, most_peers, drained_at_)) {
        ++counters_.too_many_peers;
        return nullptr;
    }
    try {
        return &peers_.emplace(log.broker, Peer{PeerWriters(participant_, self_, log), drained_at_})
                    .first->second;
    } catch (const DdsError& error) {
        spdlog::warn("a peer cannot be answered: {}", error.what());
        return nullptr;
    }
}

}  // namespace romano::dds
