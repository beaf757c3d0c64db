// A client made of datagrams: says octets, hears octets, and does nothing by itself. Nothing is
// repeated and nothing answered unless the case says so.
//
//     robot.says(subscribe(qos1, 5, topic));
//     robot.hears(suback(qos1, id, 5));
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "romano/base/endpoint.h"
#include "tests/conformance/datagrams.h"

namespace romano::conformance {

class Client {
public:
    /// Its own socket, whose address the broker sees; it hears that broker only.
    Client(const Endpoint& broker, std::string client_id);
    ~Client();
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;

    void says(const Octets& datagram) const;

    /// The next datagram, waiting for it as long as is needed; empty when none comes.
    [[nodiscard]] Octets next(std::chrono::milliseconds patience = std::chrono::seconds{20});
    /// The next datagram is exactly this; probes of the broker (6.11b) may come at any time and are
    /// passed over, unless one is expected.
    void hears(const Octets& expected);
    /// Passes over all datagrams until exactly this one comes.
    void hears_in_time(const Octets& expected,
                       std::chrono::milliseconds patience = std::chrono::seconds{20});

    struct Registered {
        std::uint16_t topic_id = 0;
        std::uint16_t msg_id = 0;
    };
    /// The next datagram is a REGISTER of that name; answered unless said otherwise.
    Registered hears_register(std::string_view name, bool answers = true);
    /// The next datagram is that PUBLISH, whatever its msg id, which is returned. Not answered.
    std::uint16_t hears_publish(Flags flags, unsigned topic, std::string_view data);
    /// And answers it to the end of its QoS.
    void takes(Flags flags, unsigned topic, std::string_view data);

    // Whole exchanges, which must go well.
    void connects(Flags flags = clean, unsigned duration_s = 0);
    void connects_with_will(std::string_view topic, std::string_view message, Flags will = no_flags,
                            Flags flags = clean, unsigned duration_s = 0);
    void disconnects();
    void sleeps(unsigned duration_s = 60);
    std::uint16_t registers(std::string_view name);
    std::uint16_t subscribes(std::string_view filter, int qos = 0);
    void publishes(unsigned topic, std::string_view data, int qos = 0, Flags more = no_flags);

    std::uint16_t next_msg_id() { return ++last_msg_id_; }

    const std::string id;

private:
    [[nodiscard]] Octets next_but_probes();

    int socket_ = -1;
    bool connected_ = false;
    std::uint16_t last_msg_id_ = 0x0100;  // both octets count
};

}  // namespace romano::conformance
