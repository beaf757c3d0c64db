// The ROMANO server of one broker: it answers the nodes whose home this broker is (paper, sections
// "Requirements" and "The ROMANO Protocol").
//
// It acknowledges connection requests, answers requests for the connected nodes, heeds heartbeats
// and has messages held back for nodes whose heartbeats are missing. The list of nodes is not kept
// here: it is the cluster's retained messages (node_entry.h), and the server only corrects the
// entries of its own nodes. Who is home to a node is the broker's matter, so never two servers
// acknowledge one request. No socket, no clock; what it does goes through the Host.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "romano/base/bytes.h"
#include "romano/base/time.h"
#include "romano/message/romano_id.h"
#include "romano/server/node_entry.h"

namespace romano::server {

inline constexpr std::string_view init_topic = "init-info";
inline constexpr std::string_view legacy_init_topic = "init_info";
inline constexpr std::string_view common_topic = "common";
/// What clients publish there must come to on_publish().
inline constexpr std::array<std::string_view, 3> observed_topics = {init_topic, legacy_init_topic,
                                                                    common_topic};

/// What moves a robot is for whoever hears it now. Retained, it would drive each robot that
/// subscribes later, on whatever topic: robots subscribe to more than their own. The authors' text
/// form could be anybody's text, so it is refused on the robots' own topics and `common` alone.
[[nodiscard]] bool is_never_retained(std::string_view topic, Bytes data);

struct ServerOptions {
    std::string name;                              // the broker's
    Duration unix_time_at_zero{0};                 // wall clock at the Instant with count 0
    Duration look_every{std::chrono::seconds{1}};  // at a thousand entries, more rarely at more
    /// A node is silent after three of its own heartbeat intervals; this long until there is one.
    Duration first_heartbeats_within{std::chrono::seconds{10}};
    Duration heartbeat_told_every{std::chrono::seconds{10}};
    Duration unclaimed_for{std::chrono::seconds{30}};  // then an entry of a lost broker is deleted
    std::size_t most_nodes = 10'000;
};

struct Standing {
    bool connected = false;
    bool kept = false;  // not a clean session: messages wait for the node though it is away
};

/// The broker that lends itself to the server for the time of a call.
class Host {
public:
    /// Of the client's session, if this broker is its home.
    [[nodiscard]] virtual std::optional<Standing> standing(std::string_view client) const = 0;
    /// The retained entries, by id.
    [[nodiscard]] virtual std::vector<NodeEntry> entries() const = 0;
    /// This broker is the one that tidies up after that one, which is gone.
    [[nodiscard]] virtual bool tidies_up_after(std::string_view home) const = 0;

    virtual void publish(std::string_view topic, Bytes data, bool retain) = 0;
    /// Messages to the client wait from now on, or go on.
    virtual void hold(std::string_view client, bool held) = 0;

protected:
    ~Host() = default;
};

struct ServerCounters {
    std::uint64_t acknowledged = 0;
    std::uint64_t lists_sent = 0;
    std::uint64_t malformed = 0;
    std::uint64_t refused = 0;  // for lack of room
};

class ServerCore {
public:
    explicit ServerCore(ServerOptions options) : options_(std::move(options)) {}

    /// A client whose home is here published on one of the observed topics.
    void on_publish(Instant now, std::string_view client, std::string_view topic, Bytes data,
                    Host& host);
    /// Early or repeated ticks are harmless.
    void on_tick(Instant now, Host& host);
    [[nodiscard]] Instant next_wakeup() const { return look_at_; }

    [[nodiscard]] const ServerCounters& counters() const { return counters_; }

private:
    /// A node whose home is here, as far as it is not in its entry.
    struct Node {
        NodeEntry told;  // as this server published it last
        std::optional<Instant> heartbeat;
        Duration interval{0};  // between its last two heartbeats; 0: unknown
        Instant told_at{};
    };

    void on_binary_request(Instant now, std::string_view client, Bytes data, Host& host);
    void on_legacy_request(Instant now, std::string_view client, Bytes data, Host& host);
    void on_heartbeat(Instant now, std::string_view client, Bytes data, Host& host);
    void welcome(Instant now, const message::RomanoId& id, std::string_view client, Form form,
                 Host& host);
    void send_list(const message::RomanoId& asker, Host& host);
    void send_legacy_list(std::string_view asker, Host& host);

    void look_at_entries(Instant now, Host& host);
    /// True when the entry's node is at home here.
    bool look_at(Instant now, const NodeEntry& entry, Host& host);
    void look_at_stranger(Instant now, const NodeEntry& entry, Host& host);
    [[nodiscard]] bool is_silent(const Node& node, Instant now) const;
    void tell(Instant now, Node& node, const NodeEntry& entry, Host& host);
    void forget(const message::RomanoId& id, Host& host);
    [[nodiscard]] std::uint64_t unix_ms(Instant instant) const;

    ServerOptions options_;
    std::map<message::RomanoId, Node> nodes_;
    std::map<message::RomanoId, Instant> unclaimed_;  // entries without a home, since when
    Instant look_at_ = Instant::min();
    ServerCounters counters_;
};

}  // namespace romano::server
