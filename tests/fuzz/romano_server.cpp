// The ROMANO server under any sequence of clients' publishes, sessions that come and go, and
// foreign entries: it sends nothing that is no message, keeps its bound, and entries go both ways.

#include <array>
#include <map>
#include <string>

#include "romano/message/codec.h"
#include "romano/server/server.h"
#include "tests/fuzz/require.h"

using namespace romano;
using namespace std::chrono_literals;

namespace {

class AnyHost final : public server::Host {
public:
    std::optional<server::Standing> standing(std::string_view client) const override {
        const auto found = sessions.find(client);
        return found == sessions.end() ? std::nullopt : std::optional{found->second};
    }
    std::vector<server::NodeEntry> entries() const override {
        std::vector<server::NodeEntry> found;
        for (const auto& [topic, text] : store) {
            if (auto entry = server::parse_entry(topic, text)) found.push_back(std::move(*entry));
        }
        return found;
    }
    bool tidies_up_after(std::string_view home) const override { return home == "gone"; }
    void publish(std::string_view topic, Bytes data, bool retain) override {
        if (!retain) {
            REQUIRE(message::RomanoId::parse(topic).has_value());
            REQUIRE(!data.empty() && data.size() <= message::max_message);
        } else if (data.empty()) {
            store.erase(std::string{topic});
        } else {
            const auto entry = server::parse_entry(topic, as_text(data));
            REQUIRE(entry.has_value());
            REQUIRE(server::to_text(*entry) == as_text(data));
            store[std::string{topic}] = as_text(data);
        }
    }
    void hold(std::string_view, bool) override {}

    std::map<std::string, server::Standing, std::less<>> sessions;
    std::map<std::string, std::string> store;
};

}  // namespace

// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Bytes input{data, size};
    AnyHost host;
    server::ServerCore core{{.name = "b1", .most_nodes = 4}};
    Instant now{1h};
    while (input.size() >= 2) {
        const std::uint8_t what = input[0];
        const std::size_t length = std::min<std::size_t>(input[1], input.size() - 2);
        const Bytes rest = input.subspan(2, length);
        input = input.subspan(2 + length);
        const std::string client(1, static_cast<char>('a' + what % 4));
        switch (what >> 5U) {
            case 0:
                now += std::chrono::seconds{length};
                core.on_tick(now, host);
                REQUIRE(core.next_wakeup() > now);
                break;
            case 1:
                host.sessions[client] = {(what & 8U) != 0, (what & 16U) != 0};
                break;
            case 2:
                host.sessions.erase(client);
                break;
            case 3:
                if (length < 8) break;
                host.store["$ROMANO/nodes/" + std::string{as_text(rest.first(8))}] =
                    as_text(rest.subspan(8));
                break;
            default:
                core.on_publish(now, client, server::observed_topics[what % 3], rest, host);
        }
    }
    return 0;
}
