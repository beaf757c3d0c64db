#include "experiments/operator/loop_request.h"

#include <charconv>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>

#include "firmware/posix/octets.h"
#include "firmware/posix/simple_laws.h"

namespace romano::experiments {
namespace {

[[noreturn]] void refuse_value(std::string_view what, std::string_view text,
                               std::string_view allowed) {
    throw std::invalid_argument(std::string{what} + " `" + std::string{text} + "`: must be " +
                                std::string{allowed});
}

template <typename Number>
std::optional<Number> number_in(std::string_view text, int base = 10) {
    Number value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
    if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
    return value;
}

void append(std::vector<std::uint8_t>& to, double value) {
    to.resize(to.size() + 4);
    firmware::put_be32(&to[to.size() - 4], value);
}

std::vector<std::uint8_t> octets_in(std::string_view text) {
    constexpr auto allowed = "up to 32 octets in hexadecimal, for example 0a0b";
    std::vector<std::uint8_t> octets;
    for (std::size_t at = 0; at < text.size(); at += 2) {
        const std::string_view digits = text.substr(at, 2);
        const auto octet = number_in<std::uint8_t>(digits, 16);
        if (!octet || digits.size() != 2) refuse_value("--parameters", text, allowed);
        octets.push_back(*octet);
    }
    if (octets.size() > control::most_parameters) refuse_value("--parameters", text, allowed);
    return octets;
}

std::vector<std::uint8_t> point_in(std::string_view text) {
    const auto comma = std::min(text.find(','), text.size());
    const auto x = number_in<std::int32_t>(text.substr(0, comma));
    const auto y =
        comma == text.size() ? std::nullopt : number_in<std::int32_t>(text.substr(comma + 1));
    if (!x || !y) refuse_value("--to", text, "a point in mm, for example 1000,500");
    std::vector<std::uint8_t> octets;
    append(octets, *x);
    append(octets, *y);
    return octets;
}

std::string milliseconds(std::uint32_t microseconds) {
    char text[24];
    std::snprintf(text, sizeof text, "%.1f", microseconds / 1000.0);
    return text;
}

}  // namespace

LawRequest law_request(std::string_view law, std::string_view parameters, std::uint32_t distance_mm,
                       std::string_view to) {
    using firmware::SimpleLaw;
    if (law == "follow") {
        LawRequest out{control::Law{static_cast<std::uint16_t>(SimpleLaw::follow)}, {}};
        append(out.parameters, distance_mm);
        return out;
    }
    if (law == "go-to") {
        return {control::Law{static_cast<std::uint16_t>(SimpleLaw::go_to)}, point_in(to)};
    }
    const auto number = number_in<std::uint16_t>(law);
    if (!number) refuse_value("--law", law, "follow, go-to, or a number from 0 to 65535");
    return {control::Law{*number}, octets_in(parameters)};
}

control::Fallback fallback_named(std::string_view name) {
    if (name == "stop") return control::Fallback::stop;
    if (name == "hold") return control::Fallback::hold;
    if (name == "own-law") return control::Fallback::own_law;
    refuse_value("--fallback", name, "stop, hold or own-law");
}

message::RomanoId robot_id(std::string_view what, std::string_view text) {
    const auto id = message::RomanoId::parse(text);
    if (!id) refuse_value(what, text, "the id of a robot, 8 lower-case hexadecimal digits");
    return *id;
}

std::string to_line(const control::Report& report) {
    const control::LoopCounters& n = report.counters;
    std::string line{control::name_of(report.state)};
    if (report.controller != message::RomanoId{}) {
        line += report.state == control::State::controlled ? " by " : ", controller ";
        line += report.controller.text();
    }
    if (n.samples > 0) {
        line += ": " + std::to_string(n.samples) + " samples, " + std::to_string(n.accepted) +
                " commands carried out, " + std::to_string(n.late) + " late, " +
                std::to_string(n.repeated) + " repeated, " + std::to_string(n.foreign) +
                " foreign; fell back " + std::to_string(n.falls) + " times";
    }
    if (n.accepted > 0) {
        line += "; age " + milliseconds(report.ages.smoothed) + " ms (" +
                milliseconds(report.ages.least) + " to " + milliseconds(report.ages.greatest) +
                ", jitter " + milliseconds(report.ages.jitter) + ")";
    }
    return line;
}

nlohmann::ordered_json to_json(const control::Report& report) {
    const control::LoopCounters& n = report.counters;
    const control::Ages& ages = report.ages;
    return {{"plant", report.plant.text()},
            {"channel", static_cast<unsigned>(report.channel)},
            {"controller", report.controller.text()},
            {"session", static_cast<std::uint32_t>(report.session)},
            {"state", control::name_of(report.state)},
            {"reason", control::name_of(report.reason)},
            {"samples", n.samples},
            {"carried_out", n.accepted},
            {"late", n.late},
            {"repeated", n.repeated},
            {"foreign", n.foreign},
            {"fell_back", n.falls},
            {"age_us",
             {{"last", ages.last},
              {"least", ages.least},
              {"smoothed", ages.smoothed},
              {"greatest", ages.greatest},
              {"jitter", ages.jitter}}}};
}

}  // namespace romano::experiments
