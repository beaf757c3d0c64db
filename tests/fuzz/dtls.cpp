// What comes to a broker's DTLS address: without a key nothing gets past it but SEARCHGW, no
// handshake is agreed on, and who has an association goes on undisturbed.

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "broker/dtls/openssl/listener.h"
#include "broker/dtls/own_id.h"
#include "romano/mqttsn/decode.h"
#include "tests/fuzz/require.h"

using namespace romano;
using namespace romano::dtls;

namespace {

using Octets = std::vector<std::uint8_t>;

constexpr std::array<std::uint8_t, 2> pingreq{0x02, 0x16};
constexpr std::array<std::uint8_t, own_id_octets> id_of_r2{1,    0xC1, 0xC2, 0xC3,
                                                           0xC4, 0xC5, 0xC6, 0xC7};

struct Broker {
    Broker() {
        const std::array<broker::ProtectedClient, 2> all{broker::ProtectedClient{"r1", {{0x5A}}},
                                                         broker::ProtectedClient{"r2", {{0x5B}}}};
        listener.set_clients(all);
        path.via.packets = Endpoint::Packets::dtls;
        listener.clients().add({"r1", AssociationId{1}, path, keys});
        const Agreed roaming{"r2", own_id_of(id_of_r2), path, keys, ConnectionId{}};
        listener.clients().add(roaming);
    }
    /// With an id it is of r2, else of r1.
    Octets record_of_client(Bytes id) {
        Octets record(pingreq.size() + most_overhead);
        record.resize(cipher.seal(keys.suite, keys.client, ContentType::application_data, 1,
                                  pingreq, record, id));
        return record;
    }
    /// What the core gets.
    std::vector<Octets> take(Bytes datagram) {
        actions.clear();
        std::vector<Octets> delivered;
        listener.take(Instant{}, path, datagram, actions, [&](const Message& message) {
            delivered.emplace_back(message.octets.begin(), message.octets.end());
        });
        return delivered;
    }

    const RecordKeys keys{Suite::aes_128_ccm_8, {{1}, {2}}, {{3}, {4}}};
    Path path{{.address = {127, 0, 0, 1}, .port = 8883, .family = Endpoint::Family::ipv4},
              {.address = {127, 0, 0, 2}, .port = 4711, .family = Endpoint::Family::ipv4}};
    protection::Reserve reserve{0};
    Listener listener{{1, reserve}, {0x5E}};
    RecordCipher cipher;
    broker::Actions actions;
};

}  // namespace

/// Datagrams, each behind two octets of length.
// NOLINTNEXTLINE(readability-identifier-naming): the name that libFuzzer calls
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    Broker broker;
    Bytes rest{data, size};
    while (rest.size() >= 2) {
        const std::size_t length = std::min<std::size_t>(be16(rest, 0), rest.size() - 2);
        const Bytes datagram = rest.subspan(2, length);
        rest = rest.subspan(2 + length);
        for (const Octets& message : broker.take(datagram)) {
            REQUIRE(mqttsn::decode_frame(message)->type == mqttsn::MsgType::searchgw);
        }
    }
    REQUIRE(broker.listener.handshakes().agreed() == 0);
    REQUIRE(broker.listener.clients().counters().moved == 0);
    for (const Bytes id : {Bytes{}, Bytes{id_of_r2}}) {
        const Octets record = broker.record_of_client(id);
        const auto delivered = broker.take(record);
        REQUIRE(delivered.size() == 1);
        REQUIRE(std::ranges::equal(Bytes{delivered[0]}.last(pingreq.size()), pingreq));
        REQUIRE(broker.take(record).empty());
    }
    return 0;
}
