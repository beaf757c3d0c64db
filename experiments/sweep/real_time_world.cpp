#include "experiments/sweep/real_time_world.h"

#include <algorithm>
#include <array>
#include <boost/asio/executor_work_guard.hpp>
#include <chrono>
#include <ctime>

#include "broker/net/clock.h"

namespace romano::experiments {
namespace {

using namespace std::chrono_literals;

}  // namespace

std::string RealTimeWorld::date() const {
    const std::time_t now = std::time(nullptr);
    std::tm utc{};
    ::gmtime_r(&now, &utc);
    std::array<char, 32> text{};
    std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
    return text.data();
}

bool RealTimeWorld::run_until(Instant deadline, const std::function<bool()>& done,
                              const std::function<void()>& look) {
    const auto end = net::to_steady_clock(deadline);
    const auto stays = boost::asio::make_work_guard(io_);
    io_.restart();
    while (!done()) {
        const Instant now = net::now();
        if (now >= deadline) return false;
        look();
        io_.run_one_until(std::min(end, net::to_steady_clock(now + 20ms)));
    }
    return true;
}

void RealTimeWorld::finish_moment() {
    io_.restart();
    io_.poll();
}

}  // namespace romano::experiments
