// From the threads of DDS to the one thread of the broker: "there is something to take".
//
// Rings that come before the broker got around to the first one are one ring. DDS calls from the
// thread that also handles acknowledgements: ring() neither blocks nor writes a sample.
#pragma once

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <functional>
#include <memory>
#include <utility>

namespace romano::dds {

class Wakeup : public std::enable_shared_from_this<Wakeup> {
public:
    Wakeup(boost::asio::io_context& io, std::function<void()> on_ring)
        : io_(io), on_ring_(std::move(on_ring)) {}

    /// From any thread.
    void ring() {
        if (ringing_.exchange(true)) return;
        boost::asio::post(io_, [weak = weak_from_this()] {
            if (const auto self = weak.lock()) self->answer();
        });
    }

private:
    void answer() {
        // First, so that what arrives while we take rings again.
        ringing_.store(false);
        on_ring_();
    }

    boost::asio::io_context& io_;
    std::function<void()> on_ring_;
    std::atomic<bool> ringing_{false};
};

}  // namespace romano::dds
