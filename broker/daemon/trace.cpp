#include "broker/daemon/trace.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <array>
#include <cstdio>
#include <memory>
#include <utility>

#include "broker/net/clock.h"

namespace romano::daemon {
namespace {

/// Seconds since the machine booted, suspended or not (CLOCK_BOOTTIME): the one clock that all
/// processes of a machine share, so that traces of several brokers can be laid side by side.
class MonotonicSeconds : public spdlog::custom_flag_formatter {
public:
    void format(const spdlog::details::log_msg&, const std::tm&,
                spdlog::memory_buf_t& out) override {
        std::array<char, 32> text{};
        const double seconds = std::chrono::duration<double>(net::now().time_since_epoch()).count();
        const int size = std::snprintf(text.data(), text.size(), "%.6f", seconds);
        out.append(text.data(), text.data() + size);
    }
    [[nodiscard]] std::unique_ptr<custom_flag_formatter> clone() const override {
        return std::make_unique<MonotonicSeconds>();
    }
};

}  // namespace

void start_trace(const std::string& level) {
    auto logger = spdlog::stderr_logger_mt("romano-broker");
    auto formatter = std::make_unique<spdlog::pattern_formatter>();
    formatter->add_flag<MonotonicSeconds>('*').set_pattern("%Y-%m-%d %H:%M:%S.%e [%*] %l: %v");
    logger->set_formatter(std::move(formatter));
    logger->set_level(spdlog::level::from_str(level));
    logger->flush_on(spdlog::level::warn);
    spdlog::set_default_logger(std::move(logger));
}

}  // namespace romano::daemon
