// Application 3 of the ROMANO paper: "ROMANO to Control Peer-to-Peer UDP Communication".
//
//     asker                          replier
//       |------ UDP-SEND-REQ ----------->|    again and again, until
//       |<----- UDP-SEND-GO -------------|    (both through the brokers)
//       |~~~~~~ a packet by radio ~~~~~~>|    heard at so many dBm: one step away or closer
//       replier                      asker
#include <algorithm>
#include <boost/asio/post.hpp>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <numeric>
#include <stdexcept>

#include "broker/net/clock.h"
#include "experiments/applications/applications.h"
#include "experiments/applications/field.h"
#include "overlay/radio/propagation.h"
#include "romano/base/bytes.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;
using radio::Place;
using radio::RadioLink;
using radio::RadioModel;

constexpr double wanted_dbm = -60;
constexpr std::uint32_t step_mm = 100;
constexpr std::size_t packets = 400;
constexpr Duration ask_again_after = 250ms;
constexpr Duration packet_within = 250ms;  // then the link is too weak
constexpr double settled_within_db = 3;    // of the mean, over the last quarter of the packets

/// What one packet told its receiver.
struct Heard {
    double at_s;
    std::size_t receiver;
    double dbm;  // not a number: not heard
    double distance_m;
};

class Pair {
public:
    Pair(Field& field, std::uint64_t seed) : field_(field), link_(RadioModel{}, seed) {}

    bool hears(std::size_t robot, const message::Message& message);
    void begin() {
        begun_ = net::now();
        asker_ = 0;
        ask();
    }
    /// Repeats what got lost.
    void look_after();
    [[nodiscard]] const std::vector<Heard>& heard() const { return heard_; }

private:
    static std::size_t other(std::size_t robot) { return 1 - robot; }
    void say(std::size_t to, const message::Message& message);
    void ask();
    void transmit();
    void on_packet(double dbm);
    void become_asker(std::size_t robot);
    [[nodiscard]] Place place(std::size_t robot) const {
        return {field_.pose(robot).x_mm / 1e3, field_.pose(robot).y_mm / 1e3};
    }

    Field& field_;
    RadioLink link_;
    std::size_t asker_ = 0;
    bool promised_ = false;  // the replier said GO
    Instant again_at_ = never;
    Instant begun_{};
    std::vector<Heard> heard_;
};

void Pair::say(std::size_t to, const message::Message& message) {
    field_.robot(other(to)).publish("0000c00" + std::to_string(to), message,
                                    mqttsn::Qos::at_least_once);
}

void Pair::ask() {
    again_at_ = net::now() + ask_again_after;
    say(other(asker_), message::UdpSendReq{});
}

bool Pair::hears(std::size_t robot, const message::Message& message) {
    // Answered after the robot has done what it is at.
    if (std::holds_alternative<message::UdpSendReq>(message)) {
        boost::asio::post(field_.io(), [this, robot] {
            if (robot == asker_) return;  // a repetition that came late
            promised_ = true;
            again_at_ = net::now() + packet_within;
            say(asker_, message::UdpSendGo{});
        });
        return true;
    }
    if (std::holds_alternative<message::UdpSendGo>(message)) {
        boost::asio::post(field_.io(), [this, robot] {
            if (robot == asker_ && promised_) transmit();
        });
        return true;
    }
    return false;
}

void Pair::transmit() {
    const double dbm = link_.packet_dbm(place(asker_), place(other(asker_)));
    if (link_.is_received(dbm)) on_packet(dbm);
}

void Pair::on_packet(double dbm) {
    const std::size_t receiver = other(asker_);
    const bool strong = dbm > wanted_dbm;  // false for what was not heard
    heard_.push_back({std::chrono::duration<double>(net::now() - begun_).count(), receiver, dbm,
                      distance_m(place(0), place(1))});
    romano_command step{};
    step.type = strong ? 0 : 1;  // front is away from the other: they stand back to back
    step.size = 4;
    put_be16(MutableBytes{step.arguments}, 2, step_mm);
    field_.robot(receiver).carry_out(step);
    become_asker(receiver);
}

void Pair::become_asker(std::size_t robot) {
    asker_ = robot;
    promised_ = false;
    if (heard_.size() < packets) ask();
}

void Pair::look_after() {
    if (net::now() < again_at_ || heard_.size() >= packets) return;
    if (promised_) {
        on_packet(std::nan(""));
    } else {
        ask();
    }
}

struct Settled {
    double mean_dbm;
    double deviation_db;
};

Settled over_last_quarter(const std::vector<Heard>& heard) {
    std::vector<double> dbm;
    for (std::size_t i = heard.size() * 3 / 4; i < heard.size(); ++i) {
        if (!std::isnan(heard[i].dbm)) dbm.push_back(heard[i].dbm);
    }
    if (dbm.empty()) throw std::runtime_error("the robots lost each other");
    const double mean = std::reduce(dbm.begin(), dbm.end()) / static_cast<double>(dbm.size());
    double square = 0;
    for (const double each : dbm) square += (each - mean) * (each - mean);
    return {mean, std::sqrt(square / static_cast<double>(dbm.size()))};
}

PlotPanel panel(const std::string& title, const std::string& y_label) {
    return {.title = title,
            .x_label = "packet",
            .y_label = y_label,
            .series = {},
            .ticks_at_points = false};
}

void write_results(const std::vector<Heard>& heard, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    std::ofstream csv(folder / "radio_distance.csv");
    csv << "packet,at_s,receiver,dbm,distance_m\n";
    PlotPanel strength = panel("Strength of each packet", "dBm");
    PlotPanel way = panel("Distance between the robots", "m");
    strength.series = {{.label = "heard", .points = {}, .line = false, .small = true},
                       {.label = "wanted", .points = {}}};
    way.series = {{.label = "", .points = {}}};
    for (std::size_t i = 0; i < heard.size(); ++i) {
        const auto packet = static_cast<double>(i + 1);
        csv << i + 1 << ',' << heard[i].at_s << ",0000c00" << heard[i].receiver << ',';
        if (!std::isnan(heard[i].dbm)) {
            csv << heard[i].dbm;
            strength.series[0].points.push_back({.x = packet, .y = heard[i].dbm});
        }
        csv << ',' << heard[i].distance_m << '\n';
        way.series[0].points.push_back({.x = packet, .y = heard[i].distance_m});
    }
    strength.series[1].points = {{.x = 1, .y = wanted_dbm},
                                 {.x = static_cast<double>(heard.size()), .y = wanted_dbm}};
    if (!csv) throw std::runtime_error("cannot write into `" + folder.string() + "`");
    const auto svg = draw({.name = "radio_distance", .panels = {strength, way}}, folder);
    if (svg) std::ofstream(folder / "radio_distance.svg") << *svg << '\n';
}

}  // namespace

void run_radio_distance(const ApplicationOptions& options) {
    Field field(options.host, options.port);
    Pair pair(field, options.seed);
    for (std::size_t i = 0; i < 2; ++i) {
        field.add({.id = "0000c00" + std::to_string(i),
                   .start = {.x_mm = i == 0 ? -500.0 : 500.0, .heading_deg = i == 0 ? 180.0 : 0.0},
                   .hears = [&pair, i](std::string_view, const message::Message& message) {
                       return pair.hears(i, message);
                   }});
    }
    field.wait_until_established();
    pair.begin();
    while (pair.heard().size() < packets) {
        const std::size_t before = pair.heard().size();
        field.wait_for(
            [&] {
                pair.look_after();
                return pair.heard().size() > before;
            },
            "the robots do not answer each other");
    }
    write_results(pair.heard(), options.output);
    const Settled settled = over_last_quarter(pair.heard());
    std::printf("wanted %.0f dBm; of the last %zu packets: mean %.1f dBm, deviation %.1f dB\n",
                wanted_dbm, packets / 4, settled.mean_dbm, settled.deviation_db);
    if (std::abs(settled.mean_dbm - wanted_dbm) > settled_within_db) {
        throw std::runtime_error("the link's strength did not settle");
    }
}

}  // namespace romano::experiments
