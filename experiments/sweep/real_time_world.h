// The world as it is: this machine's clock, and robots on its sockets. Where the brokers are, its
// two kinds say: on this machine (process_world.h), or on machines of a testbed
// (testbed/testbed_world.h).
#pragma once

#include <boost/asio/io_context.hpp>

#include "experiments/sweep/cell_world.h"

namespace romano::experiments {

class RealTimeWorld : public CellWorld {
public:
    [[nodiscard]] std::string date() const override;
    bool run_until(Instant deadline, const std::function<bool()>& done,
                   const std::function<void()>& look) override;
    void finish_moment() override;

protected:
    [[nodiscard]] boost::asio::io_context& io() { return io_; }

private:
    boost::asio::io_context io_{1};
};

}  // namespace romano::experiments
