// Tries whether the machines of a testbed hear each other's multicast, as their brokers must: each
// listens, each shouts its name, and says whom it heard. On IPv4 and the group of DDS discovery.
#pragma once

#include <map>
#include <string>

namespace romano::experiments {

class MulticastTrial {
public:
    MulticastTrial(std::string name, const std::string& interface);
    ~MulticastTrial();
    MulticastTrial(const MulticastTrial&) = delete;
    MulticastTrial& operator=(const MulticastTrial&) = delete;

    /// Why it cannot listen or shout; empty when it can.
    [[nodiscard]] const std::string& trouble() const { return trouble_; }

    /// A short datagram, and one as long as the interface takes in one piece.
    void shout();
    /// Who was heard, with the length of the longest datagram, in octets without headers.
    [[nodiscard]] const std::map<std::string, int>& heard();
    /// Of the own long datagram.
    [[nodiscard]] int longest_octets() const { return longest_octets_; }

private:
    std::string name_;
    int socket_ = -1;
    int longest_octets_ = 0;
    std::string trouble_;
    std::map<std::string, int> heard_;
};

}  // namespace romano::experiments
