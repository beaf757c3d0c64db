// A DDS domain id that no other test uses at the moment, also not one of another build that runs on
// this machine: tests on one domain would hear each other.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdint>
#include <string>

namespace romano::dds {

class TestDomain {
public:
    TestDomain() {
        for (id_ = first; id_ <= last; ++id_) {
            const std::string path = "/tmp/romano-test-domain-" + std::to_string(id_);
            lock_ = open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
            if (lock_ >= 0 && flock(lock_, LOCK_EX | LOCK_NB) == 0) return;
            if (lock_ >= 0) close(lock_);
        }
        ADD_FAILURE() << "no DDS domain from " << first << " to " << last << " is free";
    }
    ~TestDomain() { close(lock_); }
    TestDomain(const TestDomain&) = delete;
    TestDomain& operator=(const TestDomain&) = delete;

    [[nodiscard]] std::uint32_t id() const { return id_; }

private:
    // A domain's UDP ports begin at 7400 + 250 * id. From 102 on they lie among those that Linux
    // gives to any socket without a port of its own, and joining fails when one of them is taken.
    static constexpr std::uint32_t first = 88;
    static constexpr std::uint32_t last = 100;
    std::uint32_t id_ = first;
    int lock_ = -1;
};

}  // namespace romano::dds
