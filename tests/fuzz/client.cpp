// A client under any sequence of calls, datagrams and times: it never sends what is no message,
// never tells more operations than were begun, and can always be ticked to rest.

#include "romano/client/client.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <variant>

#include "romano/mqttsn/codec.h"
#include "tests/fuzz/require.h"
#include "tests/fuzz/script.h"

using namespace romano;
using namespace romano::client;
using namespace romano::mqttsn;
using namespace std::chrono_literals;

namespace {

struct TightLimits {
    static constexpr std::size_t datagram_octets = 64;
    static constexpr std::size_t queue_octets = 256;
    static constexpr std::size_t topics = 3;
    static constexpr std::size_t name_octets = 24;
    static constexpr std::size_t unreleased = 2;
};

/// In the words of a client's calls.
class ClientScript : public fuzz::Script {
public:
    using Script::Script;
    std::string_view text() { return as_text(octets()); }
    Qos qos() { return static_cast<Qos>(octet() & 3U); }
    TopicRef topic() {
        switch (octet() % 3U) {
            case 0:
                return topic_name(text());
            case 1:
                return short_topic(text());
            default:
                return predefined_topic(TopicId{octet()});
        }
    }
};

/// What a broker says to `request`: makes deep exchanges likely, which random octets do not reach.
struct Answering {
    TopicId id;
    ReturnCode code;

    Message operator()(const Connect& m) const {
        return m.will ? Message{Willtopicreq{}} : Message{Connack{code}};
    }
    Message operator()(const Willtopic&) const { return Willmsgreq{}; }
    Message operator()(const Willmsg&) const { return Connack{code}; }
    Message operator()(const Register& m) const { return Regack{id, m.msg_id, code}; }
    Message operator()(const Publish& m) const {
        if (m.qos == Qos::exactly_once && code == ReturnCode::accepted) return Pubrec{m.msg_id};
        return Puback{m.topic, m.msg_id, code};
    }
    Message operator()(const Pubrel& m) const { return Pubcomp{m.msg_id}; }
    Message operator()(const Subscribe& m) const { return Suback{m.qos, id, m.msg_id, code}; }
    Message operator()(const Unsubscribe& m) const { return Unsuback{m.msg_id}; }
    Message operator()(const Willtopicupd&) const { return Willtopicresp{code}; }
    Message operator()(const Willmsgupd&) const { return Willmsgresp{code}; }
    Message operator()(const Disconnect&) const { return Disconnect{false, 0}; }
    Message operator()(const auto&) const { return Pingresp{}; }
};

class Run {
public:
    explicit Run(Bytes input) : script_(input), client_({.t_retry = 2s, .t_wait = 20s}, 1) {}

    void play() {
        while (!script_.is_over()) step();
        come_to_rest();
    }

private:
    void step() {
        switch (script_.octet() % 13U) {
            case 0: {
                ConnectOptions options{.client_id = "c"};
                const std::uint8_t flags = script_.octet();
                options.clean_session = (flags & 1U) != 0;
                options.keep_alive = std::chrono::seconds{flags >> 4U};
                if ((flags & 2U) != 0) options.will = Will{"w", as_octets("m")};
                client_.connect(now_, options, out_);
                break;
            }
            case 1:
                client_.disconnect(now_, out_);
                break;
            case 2:
                client_.sleep(now_, std::chrono::seconds{script_.octet()}, out_);
                break;
            case 3:
                client_.wake(now_, out_);
                break;
            case 4: {
                const TopicRef topic = script_.topic();
                const Qos qos = script_.qos();
                begun(client_.publish(now_, topic, script_.octets(), {.qos = qos}, out_));
                break;
            }
            case 5: {
                const TopicRef topic = script_.topic();
                begun(client_.subscribe(now_, topic, script_.qos(), out_));
                break;
            }
            case 6:
                begun(client_.unsubscribe(now_, script_.topic(), out_));
                break;
            case 7:
                begun(client_.register_name(now_, script_.text(), out_));
                break;
            case 8:
                begun(client_.update_will_topic(now_, script_.text(), {}, out_));
                break;
            case 9:
                begun(client_.update_will_message(now_, script_.octets(), out_));
                break;
            case 10:
                now_ += std::chrono::milliseconds{script_.octet() * 100};
                tick();
                return;
            default:
                client_.on_datagram(now_, script_.octets(), out_);
                break;
        }
        take_output();
    }

    void answer_last_request() {
        const auto request = decode(Bytes{last_sent_}.first(last_sent_size_));
        const Answering answering{TopicId{script_.octet()}, ReturnCode{script_.octet()}};
        if (!request) return out_.clear();
        std::uint8_t octets[16];
        const std::size_t size = encode(std::visit(answering, *request), octets);
        client_.on_datagram(now_, Bytes{octets}.first(size), out_);
    }

    void begun(const Result<OperationId, Refusal>& operation) {
        if (operation) ++open_;
    }

    void tick() {
        client_.on_tick(now_, out_);
        take_output();
    }

    void take_output() {
        for (const Bytes datagram : out_.datagrams()) {
            REQUIRE(datagram.size() <= TightLimits::datagram_octets);
            REQUIRE(decode(datagram).has_value());
            last_sent_size_ = datagram.size();
            std::copy(datagram.begin(), datagram.end(), last_sent_);
        }
        for (const Event& event : out_.events()) {
            const bool ends_operation = std::holds_alternative<Registered>(event) ||
                                        std::holds_alternative<Subscribed>(event) ||
                                        std::holds_alternative<Unsubscribed>(event) ||
                                        std::holds_alternative<Published>(event) ||
                                        std::holds_alternative<WillUpdated>(event) ||
                                        std::holds_alternative<Failed>(event);
            if (ends_operation) --open_;
        }
        REQUIRE(open_ >= 0);
        REQUIRE((open_ == 0) == client_.is_idle());
    }

    /// Without any answer the client gives up in bounded time: then only a sleeper has a timer.
    void come_to_rest() {
        for (int ticks = 0; client_.next_wakeup() != never; ++ticks) {
            if (client_.state() == State::asleep) client_.disconnect(now_, out_);
            REQUIRE(ticks < 200);
            now_ = std::max(now_, client_.next_wakeup());
            tick();
        }
        REQUIRE(client_.state() != State::connecting && client_.state() != State::disconnecting);
    }

    ClientScript script_;
    Client<TightLimits> client_;
    OutputFor<TightLimits> out_;
    Instant now_{};
    int open_ = 0;
    std::uint8_t last_sent_[TightLimits::datagram_octets];
    std::size_t last_sent_size_ = 0;
};

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Run{{data, size}}.play();
    return 0;
}
