#include "experiments/paper/backbone.h"

#include <cmath>
#include <cstdint>
#include <deque>
#include <map>
#include <ratio>
#include <utility>

#include "overlay/dds/body_codec.h"
#include "overlay/radio/channel.h"
#include "overlay/radio/propagation.h"
#include "overlay/sim/backbone.h"
#include "overlay/sim/cost.h"
#include "overlay/sim/seed.h"
#include "romano/base/random.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using lowpan::Device;

constexpr std::int64_t second = std::nano::den;
constexpr std::int64_t lasts = 20 * second;
constexpr std::int64_t begins = second;
constexpr std::size_t robots = 5;
constexpr std::size_t publish_octets = 39;  // MQTT-SN's 7 and the paper's 32
constexpr std::size_t router_queue = 508;   // the host's and the router's
constexpr std::size_t broker_queue = 8;
constexpr std::size_t brokers_pan = 0;
constexpr std::size_t robots_pan = 1;
constexpr double metres = 5;  // from any radio to any other

/// Without losses, as one broker among so many sends them.
double octets_of_a_beacon(std::size_t brokers, const Beacons& beacons, std::uint64_t seed) {
    dds::BodyCodec codec;
    sim::CostOptions options;
    options.brokers = brokers;
    options.beacon_every = beacons.every;
    options.detection_timeout = 10 * beacons.every;
    options.seed = seed;
    options.octets_of = [&codec](const cluster::ClusterMessage& message) {
        return codec.encode(message).size();
    };
    const sim::Cost cost = sim::cost_of(options);
    const auto& sent = cost.sent.at(static_cast<std::size_t>(cluster::Delivery::beacon));
    return sim::rtps_data_octets +
           (sent.messages_per_s > 0 ? sent.octets_per_s / sent.messages_per_s : 0);
}

/// Brokers that beacon and a router that serves its robots, all on one channel.
class SharedChannel {
public:
    SharedChannel(std::size_t brokers, std::uint64_t seed)
        : brokers_(brokers),
          channel_({{lowpan::last_channel, brokers - 1}, {lowpan::last_channel, robots}}, 0,
                   noise_dbm, seed,
                   {[](Device, Device) { return radio::mean_dbm({}, metres); },
                    [this](Device at, Device, const std::vector<std::uint8_t>&) {
                        if (at.cell == robots_pan) {
                            ++delivered_;
                        } else {
                            ++heard_;
                        }
                    },
                    [this](Device device) { ready_.push_back(device); }}) {}

    void beacon(std::size_t octets, std::chrono::nanoseconds every, std::uint64_t seed) {
        if (brokers_ < 2) return;  // nobody would hear it
        Random random(seed);
        for (std::size_t i = 0; i < brokers_; ++i) {
            const std::int64_t phase = random.between(0ns, every).count();
            for (std::int64_t at = begins + phase; at < begins + lasts; at += every.count()) {
                due_.emplace(at, Datagram{{brokers_pan, i}, {}, octets});
                ++beacons_;
            }
        }
    }
    void publish(std::int64_t rate) {
        for (std::int64_t i = 0; i < rate * lasts / second; ++i) {
            due_.emplace(begins + i * second / rate,
                         Datagram{{robots_pan, 0},
                                  {robots_pan, 1 + static_cast<std::size_t>(i) % robots},
                                  publish_octets});
            ++published_;
        }
    }
    /// While it lasts; what waits then is not delivered.
    void run() {
        while (true) {
            const std::int64_t due = due_.empty() ? INT64_MAX : due_.begin()->first;
            const std::int64_t now = std::min(due, channel_.next_wakeup_ns());
            if (now >= begins + lasts) break;
            channel_.run_until(now);
            while (!due_.empty() && due_.begin()->first <= now) {
                const Datagram datagram = due_.extract(due_.begin()).mapped();
                auto& queue = waiting_[datagram.from];
                const bool is_broker = datagram.from.cell == brokers_pan;
                if (queue.size() >= (is_broker ? broker_queue : router_queue)) continue;
                queue.push_back(datagram);
                if (queue.size() == 1) send(now, datagram);
            }
            while (!ready_.empty()) {
                auto& queue = waiting_[ready_.front()];
                ready_.pop_front();
                queue.pop_front();
                if (!queue.empty()) send(now, queue.front());
            }
        }
    }

    [[nodiscard]] double delivered_share() const {
        return static_cast<double>(delivered_) / static_cast<double>(published_);
    }
    [[nodiscard]] double delivered_per_s() const {
        return static_cast<double>(delivered_) * second / lasts;
    }
    [[nodiscard]] double heard_share() const {
        if (beacons_ == 0) return 1;
        return static_cast<double>(heard_) / static_cast<double>(beacons_ * (brokers_ - 1));
    }
    [[nodiscard]] double air_of_beacons() const {
        std::int64_t sum = 0;
        for (std::size_t i = 0; i < brokers_; ++i) {
            sum += lowpan::air_time_ns(channel_.sent_by({brokers_pan, i}));
        }
        return static_cast<double>(sum) / lasts;
    }

private:
    struct Datagram {
        Device from;
        Device to;  // of robots; brokers send to all
        std::size_t octets;
    };
    static constexpr double noise_dbm = -92.87;  // as overlay/radio has it

    void send(std::int64_t now, const Datagram& datagram) {
        const std::vector<std::uint8_t> octets(datagram.octets, 'x');
        if (datagram.from.cell == brokers_pan) {
            channel_.broadcast(now, datagram.from, octets);
        } else {
            channel_.send(now, datagram.from, datagram.to, octets);
        }
    }

    std::size_t brokers_;
    std::multimap<std::int64_t, Datagram> due_;
    std::map<Device, std::deque<Datagram>> waiting_;
    std::deque<Device> ready_;
    std::size_t beacons_ = 0;
    std::size_t published_ = 0;
    std::size_t heard_ = 0;
    std::size_t delivered_ = 0;
    lowpan::Channel channel_;
};

}  // namespace

BackboneRun backbone_run(std::size_t brokers, const Beacons& beacons, std::uint64_t seed) {
    BackboneRun run;
    run.beacon_octets = octets_of_a_beacon(brokers, beacons, seed);
    const auto octets = static_cast<std::size_t>(std::lround(run.beacon_octets));
    {
        SharedChannel light(brokers, seed);
        light.beacon(octets, beacons.every, sim::seed_of(seed, "beacons"));
        light.publish(100);
        light.run();
        run.beacons_air = light.air_of_beacons();
        run.beacons_heard = light.heard_share();
        run.delivered_at_100 = light.delivered_share();
    }
    SharedChannel full(brokers, seed);  // ns-3 has one simulator: the other one is gone
    full.beacon(octets, beacons.every, sim::seed_of(seed, "beacons"));
    full.publish(300);
    full.run();
    run.carried_per_s = full.delivered_per_s();
    return run;
}

}  // namespace romano::experiments
