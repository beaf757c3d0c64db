// An emulator of the ROMANO authors' firmware, octet by octet: RIOT's emcute with the settings of
// their radio, the controller's ASCII messages behind it, and their habits. It connects once and
// never again, sends requests again unchanged after 15 s, refuses DUP, RETAIN and QoS 2 (return
// code 3), ignores REGISTER and DISCONNECT from the broker, cuts data at the first NUL.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "romano/base/endpoint.h"

namespace romano::system {

class LegacyRobot {
public:
    LegacyRobot(const Endpoint& local, const Endpoint& gateway, std::string id);
    ~LegacyRobot();
    LegacyRobot(const LegacyRobot&) = delete;
    LegacyRobot& operator=(const LegacyRobot&) = delete;

    /// CONNECT, both SUBSCRIBEs, REGISTER, and `0`+id once a second until any message comes.
    bool establish();
    bool run_until(const std::function<bool()>& done,
                   std::chrono::milliseconds limit = std::chrono::seconds{20});

    struct Delivered {
        std::string topic;
        std::string data;
    };
    std::vector<Delivered> delivered;     // to the controller
    std::vector<std::string> movements;   // MOVE_CMD, without its first octet
    std::vector<std::string> subscribed;  // SUB_CMD that the gateway confirmed
    int connects = 0;
    int hellos = 0;
    int refusals = 0;  // PUBACKs with a return code other than 0
    int disconnects_ignored = 0;

private:
    using Octets = std::vector<std::uint8_t>;

    bool request(const Octets& datagram, std::uint8_t answer);
    bool subscribe(const std::string& topic);
    std::uint16_t topic_id(const std::string& topic);
    void publish(const std::string& topic, const std::string& data);
    void send(const Octets& datagram) const;
    bool receive(std::chrono::milliseconds limit);
    void on_publish(const Octets& packet);
    void carry_out(const std::string& topic, std::string data);
    std::uint16_t next_id() { return last_id_++; }

    int socket_ = -1;
    std::string id_;
    std::uint16_t last_id_ = 0x1234;
    std::map<std::uint16_t, std::string> subscriptions_;
    std::map<std::string, std::uint16_t> topics_;  // registered, for the life of the process
    std::vector<std::string> commands_;            // of the controller: it handles one at a time
    std::uint8_t awaited_ = 0;
    Octets answer_;
};

}  // namespace romano::system
