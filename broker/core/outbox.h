// The way out: a message for a client becomes octets in the actions, wrapped for its forwarder if
// it has one (MQTT-SN 1.2 section 5.5), and waits for the log if it promises something.
#pragma once

#include <cstdint>

#include "broker/core/session.h"
#include "broker/core/tables.h"
#include "romano/mqttsn/codec.h"

namespace romano::broker {

/// Whether a datagram may leave at once or promises what the log must hold first.
enum class Gate : std::uint8_t { open, logged };

class Outbox {
public:
    explicit Outbox(Tables& tables) : tables_(tables) {}

    /// To the session's address. Never overtakes an earlier datagram to the same session. False
    /// when the message is too long for a datagram.
    template <typename M>
    bool send(Session& session, const M& message, Gate gate, Turn& turn) {
        if (gate == Gate::logged) session.output_floor = tables_.log.last();
        return put({session.header.via, session.header.address, session.output_floor}, message,
                   turn);
    }

    /// Where the octets of a datagram of this turn are.
    struct Octets {
        std::uint32_t offset;
        std::uint32_t size;
    };
    [[nodiscard]] static Octets last_sent(const Turn& turn);

    /// A PUBLISH of this turn with these octets, to another session without a forwarder.
    void repeat(const Session& session, Octets octets, Turn& turn);

    /// To an address, whether or not it has a session.
    template <typename M>
    void answer(const Endpoint& via, const ClientAddress& to, const M& message, Turn& turn) {
        const Session* session = tables_.sessions.find(Origin{via, to});
        put({via, to, session == nullptr ? 0 : session->output_floor}, message, turn);
    }

    template <typename M>
    void multicast(std::uint8_t radius, const M& message, Turn& turn) {
        const MutableBytes room = turn.out.reserve(16);
        const auto size = mqttsn::encode(message, room);
        const std::uint32_t offset = turn.out.commit(size);
        turn.out.push(Multicast{radius, offset, static_cast<std::uint32_t>(size)});
        count(M::type);
    }

private:
    /// A message with neither name nor data takes no more.
    static constexpr std::size_t most_fixed = 16;

    template <typename M>
    static std::size_t most_octets(const M&) {
        return most_fixed;
    }
    static std::size_t most_octets(const mqttsn::Register& m) {
        return most_fixed + m.topic_name.size();
    }
    static std::size_t most_octets(const mqttsn::Publish& m) { return mqttsn::encoded_size(m); }

    template <typename M>
    bool put(Send send, const M& message, Turn& turn) {
        if (turn.out.is_full()) {  // lost on the way, as UDP may
            tables_.count(Drop::output_full);
            return true;
        }
        const std::size_t wrapping = wrapping_of(send.to);
        const MutableBytes room = turn.out.reserve(wrapping + most_octets(message));
        const std::size_t size = mqttsn::encode(message, room.subspan(wrapping));
        if (size == 0 || wrapping + size > mqttsn::max_datagram) {
            (void)turn.out.commit(0);
            return false;
        }
        if (wrapping != 0) wrap(send.to, room);
        send.offset = turn.out.commit(wrapping + size);
        send.size = static_cast<std::uint32_t>(wrapping + size);
        turn.out.push(std::move(send));
        count(M::type);
        return true;
    }

    static std::size_t wrapping_of(const ClientAddress& to) {
        return to.wireless_node_id.empty() ? 0 : 3 + to.wireless_node_id.size();
    }
    static void wrap(const ClientAddress& to, MutableBytes room);
    void count(mqttsn::MsgType type) {
        ++tables_.counters.sent_by_type[static_cast<std::size_t>(type)];
    }

    Tables& tables_;
};

}  // namespace romano::broker
