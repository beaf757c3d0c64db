#include "experiments/sweep/cell.h"

#include <array>
#include <cassert>
#include <cstdio>
#include <utility>

namespace romano::experiments {
namespace {

std::string shortest(double number) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%g", number);
    return text.data();
}

/// "routers 115200 baud", "routers without UART".
std::string line_text(const char* whose, const std::string& baud) {
    if (baud.empty()) return "";
    return std::string{whose} + (baud == "none" ? " without UART" : " " + baud + " baud");
}

}  // namespace

QosMix::QosMix(std::vector<std::uint8_t> levels) : levels_(std::move(levels)) {
    assert(!levels_.empty());
}

std::string QosMix::text() const {
    std::string text;
    for (const std::uint8_t level : levels_) {
        if (!text.empty()) text += '+';
        text += static_cast<char>('0' + level);
    }
    return text;
}

std::optional<QosMix> parse_qos_mix(std::string_view text) {
    std::vector<std::uint8_t> levels;
    for (std::size_t i = 0; i < text.size(); ++i) {
        if (i % 2 == 1) {
            if (text[i] != '+') return std::nullopt;
        } else {
            if (text[i] < '0' || text[i] > '2') return std::nullopt;
            levels.push_back(static_cast<std::uint8_t>(text[i] - '0'));
        }
    }
    if (text.size() % 2 == 0) return std::nullopt;
    return QosMix{std::move(levels)};
}

std::string backbone_text(const Cell& cell) {
    return cell.backbone.empty() ? "" : "backbone " + cell.backbone;
}

std::string router_baud_text(const Cell& cell) {
    return line_text("routers", cell.router_baud);
}

std::string robot_baud_text(const Cell& cell) {
    return line_text("robots", cell.robot_baud);
}

std::string describe(const Cell& cell) {
    std::string text = std::to_string(cell.brokers) +
                       (cell.brokers == 1 ? " broker, " : " brokers, ") +
                       std::to_string(cell.robots) + (cell.robots == 1 ? " robot, " : " robots, ") +
                       shortest(cell.rate_per_s) + "/s of " + std::to_string(cell.payload_octets) +
                       " octets, QoS " + cell.qos.text();
    if (!cell.elector.empty())
        text += ", " + cell.elector + "/" + cell.detector + "/acks " + cell.acks;
    if (cell.clients != "plain") text += ", " + cell.clients;
    if (!cell.backbone.empty() && cell.backbone != "wire") text += ", " + backbone_text(cell);
    if (!cell.router_baud.empty()) {
        text += ", " + router_baud_text(cell) + ", " + robot_baud_text(cell);
    }
    text += ", ";
    text += cell.fault == Fault::none ? "no fault" : name_of(cell.fault);
    text +=
        ", seed " + std::to_string(cell.seed) + ", repetition " + std::to_string(cell.repetition);
    return text;
}

}  // namespace romano::experiments
