// A box between one client and one broker that gives the client an address of its own, and another
// one whenever the test says so: what a NAT does after a quiet minute, or the next access point.
#pragma once

#include <atomic>
#include <mutex>
#include <thread>

#include "romano/base/endpoint.h"

namespace romano::system {

class SmallNat {
public:
    /// The client sends to inside(); the broker sees `outside` with a port of the kernel's.
    SmallNat(const Endpoint& inside, const Endpoint& outside, const Endpoint& broker);
    ~SmallNat();
    SmallNat(const SmallNat&) = delete;
    SmallNat& operator=(const SmallNat&) = delete;

    [[nodiscard]] const Endpoint& inside() const { return inside_; }
    /// From now on the broker sees the client elsewhere; nobody is where it was.
    void move();

private:
    void carry();

    Endpoint inside_;
    Endpoint outside_;
    Endpoint broker_;
    int inner_;
    int outer_;
    std::mutex moving_;
    std::atomic<bool> ends_{false};
    std::thread thread_;
};

}  // namespace romano::system
