// The transport between broker processes: Cyclone DDS.
//
// Topics: romano_beacon (best-effort), romano_log (reliable), and an inbox and a forward topic a
// broker (peer_writers.h). A peer is known from its first sample on. Samples are taken on the
// io_context's thread. A body that is no message is dropped and counted;
// of a broker that speaks another protocol people are told once.
#pragma once

#include <boost/asio/io_context.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "broker/core/log_position.h"
#include "overlay/dds/beacon_sender.h"
#include "overlay/dds/body_codec.h"
#include "overlay/dds/domain.h"
#include "overlay/dds/later_life.h"
#include "overlay/dds/peer_writers.h"
#include "overlay/dds/sample_reader.h"
#include "overlay/dds/sample_writer.h"
#include "overlay/dds/wakeup.h"
#include "overlay/pulses.h"
#include "overlay/transport.h"

namespace romano::dds {

struct TransportCounters {
    std::uint64_t sent = 0;
    std::uint64_t sent_octets = 0;
    std::uint64_t received = 0;
    std::uint64_t received_octets = 0;
    std::uint64_t write_failed = 0;    // DDS did not take it
    std::uint64_t unknown_peer = 0;    // to a broker that was never heard
    std::uint64_t malformed = 0;       // a body that is no message
    std::uint64_t other_protocol = 0;  // of a broker whose version speaks another one
    std::uint64_t repeated = 0;        // DDS brought an inbox sample again
    std::uint64_t too_many_peers = 0;  // from a broker beyond the table's bound
};

class DdsTransport : public overlay::Transport {
public:
    static constexpr std::size_t most_peers = 256;

    /// `on_drained` is called after each burst of received messages, `on_later_life` when others
    /// know one (later_life.h). Throws DdsError.
    DdsTransport(boost::asio::io_context& io, const Domain& domain, const broker::LogId& self,
                 const overlay::Pulses& pulses, std::function<void()> on_drained = {},
                 LaterLife::OnKnown on_later_life = {});
    ~DdsTransport() override;

    /// Throws DdsError.
    void start(Receiver receiver) override;
    void send(const overlay::Outgoing& message) override;

    [[nodiscard]] const TransportCounters& counters() const { return counters_; }
    [[nodiscard]] std::uint64_t pulses_sent() const { return beacons_.pulses_sent(); }

private:
    struct Peer {
        PeerWriters writers;
        std::chrono::steady_clock::time_point heard_at;
        std::uint64_t last_inbox_number = 0;
    };

    void send_beacon(const cluster::ClusterMessage& message);
    void send_to_all(const cluster::ClusterMessage& message, Bytes body);
    void send_to(Peer& peer, cluster::Delivery delivery, Bytes body);
    void count_written(bool written, Bytes body);
    void drain();
    void on_sample(const SampleView& sample);
    void on_inbox_sample(const SampleView& sample);
    void refuse(const SampleView& sample);
    void tell_of_other_version(const broker::BrokerId& broker, const std::string& version);
    [[nodiscard]] Peer* peer_of(const broker::LogId& log);

    broker::LogId self_;
    std::function<void()> on_drained_;
    Receiver receiver_;
    BodyCodec codec_;
    std::vector<std::uint8_t> pulse_;
    TransportCounters counters_;
    std::shared_ptr<Wakeup> wakeup_;
    Entity participant_;
    BeaconSender beacons_;
    SampleWriter log_;
    std::optional<LaterLife> later_life_;
    std::map<broker::BrokerId, Peer> peers_;
    std::set<broker::BrokerId> told_of_;  // brokers of other versions
    struct Reading {
        std::unique_ptr<SampleReader> reader;
        void (DdsTransport::*on_sample)(const SampleView&);
    };
    std::vector<Reading> readers_;  // inbox, beacons, log, forwards
    std::size_t next_reader_ = 0;
    std::chrono::steady_clock::time_point drained_at_;
};

}  // namespace romano::dds
