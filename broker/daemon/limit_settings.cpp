#include "broker/daemon/limit_settings.h"

#include <array>

namespace romano::daemon {
namespace {

using broker::Limits;

constexpr std::array<LimitSetting, 16> limit_table{{
    {"max-sessions", &Limits::sessions, 1, 1'000'000,
     "Sessions; then clean ones left behind go, then kept ones of whichever IP address left most "
     "of them behind, but for its last one; then CONNECT hears \"congestion\""},
    {"max-kept-per-address", &Limits::kept_per_address, 1, 1'000'000,
     "Kept sessions (CleanSession 0) of one IP address whose clients are away; then the one that "
     "is "
     "away for longest is forgotten"},
    {"max-connecting", &Limits::connecting, 1, 1'000'000,
     "Clients amid their will prompts; then CONNECT hears \"congestion\""},
    {"max-subscriptions", &Limits::subscriptions_per_session, 1, 1'000'000,
     "Subscriptions of a session; then SUBSCRIBE hears \"congestion\""},
    {"max-topics", &Limits::topics_per_session, 1, 65'534,
     "Topic ids of a session; then REGISTER hears \"congestion\""},
    {"max-queued", &Limits::queued_per_session, 1, 1'000'000,
     "Messages that wait for a client; then QoS 0 goes, then new ones are dropped"},
    {"max-retained", &Limits::retained_messages, 0, 10'000'000,
     "Retained messages; then a new one hears \"congestion\""},
    {"max-unreleased", &Limits::unreleased_per_session, 1, 65'535,
     "QoS 2 publishes of a client between PUBREC and PUBREL; then the oldest is forgotten"},
    {"max-client-id-octets", &Limits::client_id_octets, 1, 1'000,
     "Length of a client id; a longer one hears \"not supported\""},
    {"max-payload-octets", &Limits::payload_octets, 1, 65'498,
     "Length of a message; a longer one hears \"not supported\""},
    {"max-stranger-rate", &Limits::stranger_datagrams_per_second, 1, 1'000'000,
     "Datagrams a second of one IP address and port without a session; the rest is dropped"},
    {"max-address-stranger-rate", &Limits::address_stranger_datagrams_per_second, 1, 10'000'000,
     "The same of one IP address, of all its ports without a session together"},
    {"max-stranger-answers", &Limits::stranger_answers_per_second, 1, 10'000'000,
     "Answers of a kind (DISCONNECT, GWINFO, \"no\" to CONNECT) a second to all addresses without "
     "a session together; the rest hear nothing"},
    {"max-pacing-ms", &Limits::pacing_ms, 0, 60'000,
     "PUBACK and PUBREC come so much later at most when a receiver's queue fills up; 0: never"},
    {"session-expiry-s", &Limits::session_expiry_s, 0, 4'294'967'295,
     "A kept session (CleanSession 0) is forgotten when its client was away for so long; 0: never"},
    {"max-memory-mb", &Limits::memory_mib, 8, 1'000'000,
     "MiB of heap in all; then nothing that stays is taken: \"congestion\"; and sessions left "
     "behind go, as with --max-sessions"},
}};

}  // namespace

std::span<const LimitSetting> limit_settings() {
    return limit_table;
}

std::map<std::string, std::string> default_limit_texts() {
    std::map<std::string, std::string> texts;
    for (const LimitSetting& setting : limit_table) {
        texts.emplace(setting.key, std::to_string(Limits{}.*setting.limit));
    }
    return texts;
}

}  // namespace romano::daemon
