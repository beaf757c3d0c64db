// The options that every subcommand shares which talks to a broker.
#pragma once

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "experiments/robots/socket_client.h"

namespace romano::experiments {

struct BrokerOptions {
    std::string host = "127.0.0.1";
    std::uint16_t port = 1883;
    std::string client_id;  // empty: one is made up
    std::uint16_t keep_alive_s = 60;
    double timeout_s = 5;      // how long a broker may not answer
    std::string key_file;      // empty: plain
    bool speaks_dtls = false;  // with the key

    void add_to(CLI::App& command);
    /// For commands whose client can be protected.
    void add_key_to(CLI::App& command);
    /// Of the key; null when none is given. Throws CommandError.
    [[nodiscard]] std::shared_ptr<keys::ClientPackets> packets() const;
    /// The client id, or a fresh one such as "romano-sub-4711", or the key's.
    [[nodiscard]] std::string id_or(const char* made_up) const;
    /// The repetitions within timeout_s.
    [[nodiscard]] client::Timing timing() const;
    /// "127.0.0.1 port 1883", for messages.
    [[nodiscard]] std::string where() const;
    /// The sentence for a broker that does not answer.
    [[nodiscard]] std::string unreachable(bool was_refused) const;

private:
    mutable std::shared_ptr<keys::ClientPackets> packets_;
};

/// -t, as a name; or by the id that broker and client have agreed on beforehand.
struct TopicOption {
    std::string name;
    std::uint16_t predefined = 0;
    bool is_short = false;

    void add_to(CLI::App& command, const char* what);
    /// Throws CommandError when it is none or both.
    [[nodiscard]] mqttsn::TopicRef topic() const;
    /// For sentences about it: "`robots/7/pose`", "predefined topic id 3".
    [[nodiscard]] std::string words() const;
};

/// --topics, of which each must be a filter. Throws CommandError.
void check_filters(const std::vector<std::string>& filters);

/// A command cannot be carried out: one sentence, exit code 2.
struct CommandError : std::runtime_error {
    using std::runtime_error::runtime_error;
};

}  // namespace romano::experiments
