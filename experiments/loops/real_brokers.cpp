#include "experiments/loops/real_brokers.h"

#include <unistd.h>

#include <chrono>
#include <stdexcept>
#include <utility>

namespace romano::experiments {
namespace {

NetworkPlace free_network() {
    auto place = claim_network("");
    if (!place) throw std::runtime_error("none of the loopback networks 127.50 to 127.99 is free");
    return std::move(*place);
}

Cell cell_with(std::size_t brokers) {
    Cell cell;
    cell.number = 1;
    cell.brokers = static_cast<std::uint32_t>(brokers);
    if (brokers == 1) return cell;
    cell.elector = "component";
    cell.detector = "link";
    cell.acks = "1";
    return cell;
}

}  // namespace

RealBrokers::RealBrokers(const std::filesystem::path& program, std::size_t brokers,
                         const std::filesystem::path& traces)
    : place_(free_network()),
      cell_(cell_with(brokers)),
      world_(settings_, cell_, place_.network, program),
      brokers_(settings_, cell_, world_, [traces](const std::string& name) {
          // Runs at once write beside each other.
          return traces / (std::to_string(::getpid()) + "-" + name + ".txt");
      }) {
    brokers_.watch([] {});
    const auto limit = std::chrono::duration_cast<Duration>(settings_.start_within);
    if (!run_until([this] { return brokers_.are_whole(); }, limit)) {
        throw std::runtime_error("the brokers were not in one view in time; " +
                                 brokers_.what_they_see());
    }
}

RealBrokers::~RealBrokers() {
    brokers_.stop_all();
}

void RealBrokers::run_for(Duration duration) {
    (void)run_until([] { return false; }, duration);
}

bool RealBrokers::run_until(const std::function<bool()>& condition, Duration limit) {
    return world_.run_until(world_.now() + limit, condition, [this] { brokers_.check(); });
}

void RealBrokers::after(Duration delay, std::function<void()> action) {
    alarm_ = world_.surroundings().make_alarm(std::move(action));
    alarm_->set(world_.now() + delay);
}

}  // namespace romano::experiments
