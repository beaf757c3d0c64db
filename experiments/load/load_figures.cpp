#include "experiments/load/load_figures.h"

#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace romano::experiments {
namespace {

double us(Duration duration) {
    return std::chrono::duration<double, std::micro>(duration).count();
}

double per_second(std::uint64_t count, double seconds) {
    return seconds > 0 ? static_cast<double>(count) / seconds : 0;
}

template <typename... Values>
std::string line(const char* format, Values... values) {
    std::array<char, 256> text{};
    (void)std::snprintf(text.data(), text.size(), format, values...);
    return text.data();
}

std::string latency_line(const char* what, const LatencyHistogram& latency) {
    return line("%-16s p50 %.0f us, p90 %.0f us, p99 %.0f us, p99.9 %.0f us, most %.0f us\n", what,
                us(latency.at(0.5)), us(latency.at(0.9)), us(latency.at(0.99)),
                us(latency.at(0.999)), us(latency.max()));
}

nlohmann::ordered_json latency_json(const LatencyHistogram& latency) {
    return {{"samples", latency.count()},     {"mean_us", us(latency.mean())},
            {"p50_us", us(latency.at(0.5))},  {"p90_us", us(latency.at(0.9))},
            {"p99_us", us(latency.at(0.99))}, {"p999_us", us(latency.at(0.999))},
            {"max_us", us(latency.max())}};
}

}  // namespace

double LoadFigures::published_per_s() const {
    return per_second(published, measured_s);
}

double LoadFigures::delivered_per_s() const {
    return per_second(delivered, measured_s);
}

std::string text_of(const LoadPlan& plan, const LoadFigures& figures) {
    using Count = unsigned long long;
    std::string text =
        line("%-16s %.0f messages/s published, %.0f deliveries/s (%.1f s measured)\n", "throughput",
             figures.published_per_s(), figures.delivered_per_s(), figures.measured_s);
    if (figures.latency.count() > 0) text += latency_line("latency", figures.latency);
    if (plan.receivers_of(0) > 1 && figures.last_subscriber.count() > 0) {
        text += latency_line("last subscriber", figures.last_subscriber);
    }
    if (figures.acknowledgement.count() > 0) {
        text += latency_line("acknowledgement", figures.acknowledgement);
    }
    text += line("%-16s %llu of %llu deliveries, %llu duplicates, %llu out of order, %llu stray\n",
                 "lost", Count{figures.lost()}, Count{figures.expected}, Count{figures.duplicates},
                 Count{figures.out_of_order}, Count{figures.strays});
    if (plan.qos != mqttsn::Qos::at_most_once) {
        text += line(
            "%-16s %llu without an answer, %llu refused; %llu sent again by the clients, "
            "%llu by the broker\n",
            "acknowledged", Count{figures.unacknowledged}, Count{figures.refused},
            Count{figures.retransmissions}, Count{figures.marked_dup});
    }
    if (figures.heard_in_cell) {
        text += line("%-16s %llu of the deliveries by a datagram for many\n", "cell",
                     Count{*figures.heard_in_cell});
    }
    text += line("%-16s %.0f %% of a core", "this generator", figures.generator_cpu_percent);
    if (plan.rate_per_s) text += line(", %.0f us late at most", us(figures.worst_lag));
    if (figures.generator_cpu_percent > 95) text += ": it may be the limit, not the broker";
    text += "\n";
    if (figures.dropped_here != 0) {
        text += line(
            "%-16s %llu datagrams were lost at this generator's own sockets: part of the "
            "loss is its own\n",
            "warning", Count{figures.dropped_here});
    }
    if (figures.not_taken != 0) {
        text += line(
            "%-16s %llu messages were due and could not be published: the queue of their "
            "client was full\n",
            "warning", Count{figures.not_taken});
    }
    if (figures.lost_clients != 0) {
        text +=
            line("%-16s %llu clients lost their broker\n", "warning", Count{figures.lost_clients});
    }
    return text;
}

std::string json_of(const LoadPlan& plan, const LoadFigures& figures) {
    const nlohmann::ordered_json json{
        {"publishers", plan.publishers},
        {"subscribers", plan.subscribers},
        {"topics", plan.topics},
        {"qos", static_cast<int>(plan.qos)},
        {"payload_octets", plan.payload_octets},
        {"rate_messages_per_s",
         plan.rate_per_s ? nlohmann::ordered_json(*plan.rate_per_s) : nlohmann::ordered_json()},
        {"in_flight_messages",
         plan.rate_per_s ? nlohmann::ordered_json() : nlohmann::ordered_json(plan.in_flight)},
        {"joined_s", figures.joined_s},
        {"measured_s", figures.measured_s},
        {"published_messages_per_s", figures.published_per_s()},
        {"delivered_messages_per_s", figures.delivered_per_s()},
        {"latency", latency_json(figures.latency)},
        {"last_subscriber", latency_json(figures.last_subscriber)},
        {"acknowledgement", latency_json(figures.acknowledgement)},
        {"published_messages", figures.all_published},
        {"expected_deliveries", figures.expected},
        {"delivered", figures.all_delivered},
        {"lost", figures.lost()},
        {"duplicates", figures.duplicates},
        {"out_of_order", figures.out_of_order},
        {"strays", figures.strays},
        {"unacknowledged_messages", figures.unacknowledged},
        {"refused_messages", figures.refused},
        {"not_taken_messages", figures.not_taken},
        {"retransmissions_by_clients", figures.retransmissions},
        {"retransmissions_by_broker", figures.marked_dup},
        {"deliveries_by_cell", figures.heard_in_cell
                                   ? nlohmann::ordered_json(*figures.heard_in_cell)
                                   : nlohmann::ordered_json()},
        {"lost_clients", figures.lost_clients},
        {"generator_cpu_percent", figures.generator_cpu_percent},
        {"generator_lag_max_us", us(figures.worst_lag)},
        {"generator_dropped_datagrams", figures.dropped_here},
        {"interrupted", figures.interrupted}};
    return json.dump(2);
}

}  // namespace romano::experiments
