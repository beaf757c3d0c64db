// The broker core under any sequence of datagrams, times and cluster calls: its invariants hold
// after every step, it sends nothing that is no message, its mirror agrees, and it can always be
// ticked to rest.

#include "broker/core/broker_core.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "broker/core/mirror.h"
#include "romano/mqttsn/codec.h"
#include "tests/fuzz/require.h"
#include "tests/fuzz/script.h"

using namespace romano;
using namespace romano::broker;
using namespace std::chrono_literals;

namespace {

/// Small tables, so that a few datagrams fill them; and few ticks on the way to rest, so that an
/// input costs little: ADVERTISE, probes of silent clients and forgetting come rarely.
BrokerOptions tight_options() {
    BrokerOptions options;
    options.log = {BrokerId{1}, 1};
    options.writes_log = true;
    options.advertise_every = 6h;
    options.deletions_kept_for = 12h;
    options.keep_alive_tolerance = 1.001;
    options.predefined_topics = {{mqttsn::TopicId{1}, "p"}};
    options.limits.sessions = 4;
    options.limits.connecting = 2;
    options.limits.subscriptions_per_session = 4;
    options.limits.topics_per_session = 4;
    options.limits.queued_per_session = 4;
    options.limits.retained_messages = 3;
    options.limits.unreleased_per_session = 2;
    options.limits.payload_octets = 64;
    options.limits.session_expiry_s = 600;
    return options;
}

Endpoint client(std::uint8_t number) {
    return {.address = {127, 0, 0, 1},
            .port = static_cast<std::uint16_t>(5000 + number % 6),
            .family = Endpoint::Family::ipv4};
}

class Run {
public:
    void step(fuzz::Script& script) {
        const std::uint8_t what = script.octet();
        switch (what >> 5U) {
            case 0:
                now_ += std::chrono::seconds{script.octet()};
                core_.on_tick(now_, out_);
                break;
            case 1: {
                const Seq seq = (peer_seq_ += script.octet() % 2);
                const Bytes payload = script.octets(script.octet() % 3U);
                const MessagePtr message{
                    Message{.topic = std::string(1, static_cast<char>('a' + what % 4)),
                            .payload = {payload.begin(), payload.end()},
                            .qos = static_cast<mqttsn::Qos>(seq % 3),
                            .retain = (what & 4U) != 0,
                            .position = {{BrokerId{2}, 1}, seq},
                            .published_at = {seq}}};
                core_.on_peer_message(now_, message, out_);
                break;
            }
            case 2: {
                if ((what & 16U) != 0) {
                    core_.set_full((what & 8U) != 0);
                    core_.set_congested((what & 4U) != 0);
                    break;
                }
                const char id = static_cast<char>('a' + what % 4);
                auto image = core_.release({&id, 1}, out_);
                drain();
                if (image && (what & 8U) != 0) core_.adopt(now_, std::move(*image), {}, out_);
                break;
            }
            default:
                core_.on_datagram(now_, client(9), client(what), script.octets(), out_);
                break;
        }
        drain();
    }

    void comes_to_rest() {
        // ADVERTISE comes for ever; after two days no session is connected any more.
        const Instant end = now_ + 48h;
        for (int ticks = 0; core_.next_wakeup() < end; ++ticks) {
            REQUIRE(ticks < 1'000);
            now_ = std::max(now_, core_.next_wakeup());
            core_.on_tick(now_, out_);
            drain();
            REQUIRE(core_.next_wakeup() > now_);
        }
        core_.append_cursors(out_);
        drain();
        const auto at_home = core_.images();
        const auto mirrored = mirror_.images();
        REQUIRE(at_home.size() == mirrored.size());
        for (std::size_t i = 0; i < at_home.size(); ++i) {
            REQUIRE(same_state(at_home[i], mirrored[i]));
        }
    }

private:
    void drain() {
        for (const Action& action : out_.list()) {
            if (const auto* send = std::get_if<Send>(&action)) {
                REQUIRE(mqttsn::decode(out_.octets(*send)).has_value());
                REQUIRE(send->after <= core_.last_seq());
            } else if (const auto* append = std::get_if<Append>(&action)) {
                mirror_.apply(append->seq, *append->event);
            }
        }
        out_.clear();
        core_.check_invariants();
    }

    BrokerCore core_{tight_options(), 1};
    Mirror mirror_{tight_options().log};
    Instant now_{1s};
    Seq peer_seq_ = 0;
    Actions out_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Script script{Bytes{data, size}};
    Run run;
    while (!script.is_over()) run.step(script);
    run.comes_to_rest();
    return 0;
}
