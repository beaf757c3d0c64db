// Clients with Connection IDs of their own, whose record layer is written here a second time, by
// the text of RFC 9146 sections 3 to 5.3 alone: no client that is packaged knows RFC 9146. Its
// handshake is OpenSSL's, its AES-CCM that of romano/protection.

#include <gtest/gtest.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "romano/dtls/datagrams.h"
#include "romano/dtls/session_keys.h"
#include "romano/protection/ccm.h"
#include "tests/broker/dtls/broker_with_dtls.h"

namespace romano::dtls::standard_ids_test {
namespace {

using namespace broker_with_dtls;

Octets operator+(Octets left, Bytes right) {
    left.insert(left.end(), right.begin(), right.end());
    return left;
}
Octets be16_of(std::size_t value) {
    return {static_cast<std::uint8_t>(value >> 8U), static_cast<std::uint8_t>(value)};
}

// struct {                                   struct {
//     ContentType outer_type = tls12_cid;        opaque content[length];
//     ProtocolVersion version;                   ContentType real_type;
//     uint16 epoch; uint48 sequence_number;      uint8 zeros[length_of_padding];
//     opaque cid[cid_length];                } DTLSInnerPlaintext;
//     uint16 length;
//     opaque enc_content[length];
// } DTLSCiphertext;
constexpr std::uint8_t tls12_cid = 25;

/// additional_data of section 5.3, or with an empty id of RFC 5246 section 6.2.3.3.
Octets additional_data(std::uint8_t type, Bytes epoch_and_number, Bytes cid, std::size_t length) {
    if (cid.empty())
        return Octets{} + epoch_and_number + Octets{type, 0xFE, 0xFD} + be16_of(length);
    return Octets(8, 0xFF) +
           Octets{tls12_cid, static_cast<std::uint8_t>(cid.size()), tls12_cid, 0xFE, 0xFD} +
           epoch_and_number + cid + be16_of(length);
}

Octets nonce_of(const WriteKey& key, Bytes epoch_and_number) {
    return Octets(key.salt.begin(), key.salt.end()) + epoch_and_number;
}

Octets seal(const WriteKey& key, std::uint8_t type, Bytes epoch_and_number, Bytes cid,
            Octets content, std::size_t zeros = 0) {
    if (!cid.empty()) {
        content.push_back(type);
        content.resize(content.size() + zeros);
    }
    Octets tag(8);
    protection::Ccm(key.key, nonce_of(key, epoch_and_number))
        .seal(additional_data(type, epoch_and_number, cid, content.size()), content, tag);
    return Octets{cid.empty() ? type : tls12_cid, 0xFE, 0xFD} + epoch_and_number + cid +
           be16_of(8 + content.size() + tag.size()) + epoch_and_number + content + tag;
}

struct Unsealed {
    std::uint8_t type;
    Octets content;
};
std::optional<Unsealed> unseal(const WriteKey& key, Bytes record, Bytes cid) {
    const std::size_t header = 13 + cid.size();
    if (record.size() < header + 16 || !std::ranges::equal(record.subspan(11, cid.size()), cid)) {
        return std::nullopt;
    }
    const Bytes epoch_and_number = record.subspan(3, 8);
    Octets content(record.begin() + static_cast<std::ptrdiff_t>(header) + 8, record.end() - 8);
    const Octets tag(record.end() - 8, record.end());
    const Octets beside = additional_data(record[0], epoch_and_number, cid, content.size());
    if (!protection::Ccm(key.key, nonce_of(key, epoch_and_number)).open(beside, content, tag)) {
        return std::nullopt;
    }
    if (cid.empty()) return Unsealed{record[0], content};
    while (!content.empty() && content.back() == 0) content.pop_back();
    if (content.empty()) return std::nullopt;
    const std::uint8_t type = content.back();
    content.pop_back();
    return Unsealed{type, content};
}

class Peer final : public Datagrams {
public:
    explicit Peer(Octets own_id)
        : own_id_(std::move(own_id)), context_(SSL_CTX_new(DTLS_client_method())) {
        SSL_CTX_set_cipher_list(context_.get(), "PSK-AES128-CCM8");
        SSL_CTX_set_options(context_.get(), SSL_OP_NO_TICKET | SSL_OP_NO_QUERY_MTU);
        SSL_CTX_set_psk_client_callback(context_.get(), on_hint);
        SSL_CTX_add_custom_ext(context_.get(), 54,
                               SSL_EXT_CLIENT_HELLO | SSL_EXT_TLS1_2_SERVER_HELLO, on_offer,
                               nullptr, nullptr, on_answer, nullptr);
        ssl_ = make_ssl(context_.get());
        SSL_set_connect_state(ssl_.get());
        extension_ = Octets{static_cast<std::uint8_t>(own_id_.size())} + own_id_;
    }

    bool connect(Broker& broker) {
        for (int turn = 0; turn < 10; ++turn) {
            if (SSL_do_handshake(ssl_.get()) == 1) return true;
            for (const Octets& datagram : std::exchange(outbox_, {})) {
                for (const Sent& answer : broker.take(place, datagram)) hear(answer.octets);
            }
        }
        return false;
    }
    Octets record_of(Octets content, std::size_t zeros = 0, std::uint8_t type = 23) {
        Octets number{0, 1, 0, 0, 0, 0, 1, 0};
        number[7] = next_++;
        return seal(session_keys(ssl_.get())->keys.client, type, number, brokers_id_,
                    std::move(content), zeros);
    }
    /// Without the id that was agreed on.
    Octets ordinary_record_of(Octets content) {
        return seal(session_keys(ssl_.get())->keys.client, 23, Octets{0, 1, 0, 0, 0, 0, 2, 0}, {},
                    std::move(content));
    }
    std::optional<Unsealed> read(Bytes record) const {
        return unseal(session_keys(ssl_.get())->keys.server, record,
                      is_agreed_ ? Bytes{own_id_} : Bytes{});
    }
    bool is_agreed() const { return is_agreed_; }
    const Octets& brokers_id() const { return brokers_id_; }

private:
    struct Free {
        void operator()(SSL_CTX* context) const { SSL_CTX_free(context); }
    };
    static Peer& of(SSL* ssl) { return static_cast<Peer&>(Datagrams::of(ssl)); }
    static unsigned int on_hint(SSL*, const char*, char* identity, unsigned int, unsigned char* key,
                                unsigned int) {
        identity[0] = 'a';
        identity[1] = '\0';
        const protection::Key psk = protection::pre_shared_key(key_a);
        std::copy(psk.begin(), psk.end(), key);
        return static_cast<unsigned int>(psk.size());
    }
    static int on_offer(SSL* ssl, unsigned int, unsigned int, const unsigned char** body,
                        std::size_t* size, X509*, std::size_t, int*, void*) {
        *body = of(ssl).extension_.data();
        *size = of(ssl).extension_.size();
        return 1;
    }
    static int on_answer(SSL* ssl, unsigned int, unsigned int, const unsigned char* body,
                         std::size_t size, X509*, std::size_t, int*, void*) {
        if (size == 0 || body[0] != size - 1) return 0;
        of(ssl).is_agreed_ = true;
        of(ssl).brokers_id_.assign(body + 1, body + size);
        return 1;
    }

    void write(Bytes datagram) override {
        Octets out;
        while (datagram.size() >= 13) {
            const Bytes record = datagram.first(13U + be16(datagram, 11));
            datagram = datagram.subspan(record.size());
            if (be16(record, 3) == 0 || brokers_id_.empty()) {
                out = out + record;
                continue;
            }
            const WriteKey key = session_keys(ssl_.get())->keys.client;
            const auto in = unseal(key, record, {});
            out = out + seal(key, in->type, record.subspan(3, 8), brokers_id_, in->content);
        }
        outbox_.push_back(out);
    }
    /// Record by record: OpenSSL reads one at a time.
    void hear(Bytes datagram) {
        while (!datagram.empty()) {
            const bool has_id = datagram[0] == tls12_cid;
            const std::size_t header = 13 + (has_id ? own_id_.size() : 0);
            const Bytes record = datagram.first(header + be16(datagram, header - 2));
            datagram = datagram.subspan(record.size());
            Octets plain(record.begin(), record.end());
            if (has_id) {
                const WriteKey key = session_keys(ssl_.get())->keys.server;
                const auto in = unseal(key, record, own_id_);
                if (!in) continue;
                plain = seal(key, in->type, record.subspan(3, 8), {}, in->content);
            } else if (be16(record, 3) != 0) {
                EXPECT_TRUE(own_id_.empty() || !is_agreed_) << "what is protected has the id";
            }
            set_input(plain);
            ERR_clear_error();
            (void)SSL_do_handshake(ssl_.get());
            set_input({});
        }
    }

    Octets own_id_;
    Octets extension_;
    Octets brokers_id_;
    bool is_agreed_ = false;
    std::uint8_t next_ = 0;
    std::vector<Octets> outbox_;
    std::unique_ptr<SSL_CTX, Free> context_;
    Ssl ssl_;
};

Octets id_of(std::size_t octets) {
    Octets id(octets);
    for (std::size_t n = 0; n < octets; ++n) id[n] = static_cast<std::uint8_t>(0xE0 + n);
    return id;
}

struct AtABroker : testing::Test {
    /// The one answer's message.
    Octets ask(Peer& peer, const Octets& record, const Endpoint& from = place) {
        const auto answers = broker.take(from, record);
        if (answers.empty()) return {};
        const auto read = peer.read(answers.back().octets);
        return read && read->type == 23 ? read->content : Octets{};
    }
    Broker broker{1};
};
struct AStandardClient : AtABroker, testing::WithParamInterface<std::size_t> {};
const Octets connack = octets_of(mqttsn::Connack{mqttsn::ReturnCode::accepted});
const Octets pong = octets_of(mqttsn::Pingresp{});

INSTANTIATE_TEST_SUITE_P(WithAnIdOf, AStandardClient, testing::Values(0, 1, 8, 32));

TEST_P(AStandardClient, IsServedWithBothIdsFromAnyAddress) {
    Peer peer{id_of(GetParam())};
    ASSERT_TRUE(peer.connect(broker));
    ASSERT_TRUE(peer.is_agreed());
    EXPECT_EQ(peer.brokers_id().size(), 8U);
    EXPECT_EQ(ask(peer, peer.record_of(connect_as("a"))), connack);
    EXPECT_EQ(ask(peer, peer.record_of(ping)), pong);
    EXPECT_FALSE(broker.take(other_place, peer.record_of(ping)).empty());
    EXPECT_TRUE(broker.take(other_place, peer.record_of(pong)).empty()) << "it is there";
    EXPECT_EQ(ask(peer, peer.record_of(ping), other_place), pong);
    EXPECT_EQ(broker.core.session_count(), 1U);
}

TEST_P(AStandardClient, MayPadItsRecords) {
    Peer peer{id_of(GetParam())};
    ASSERT_TRUE(peer.connect(broker));
    EXPECT_EQ(ask(peer, peer.record_of(connect_as("a"), 16)), connack);
    EXPECT_EQ(ask(peer, peer.record_of(ping, 300)), pong);
    EXPECT_TRUE(broker.take(place, peer.record_of({}, 5)).empty()) << "nothing but padding";
    EXPECT_EQ(ask(peer, peer.record_of(ping)), pong);
}

TEST_P(AStandardClient, IsRefusedWithoutTheIdThatWasAgreedOn) {  // RFC 9146 section 4
    Peer peer{id_of(GetParam())};
    ASSERT_TRUE(peer.connect(broker));
    ASSERT_EQ(ask(peer, peer.record_of(connect_as("a"))), connack);
    EXPECT_TRUE(broker.take(place, peer.ordinary_record_of(ping)).empty());
    EXPECT_EQ(broker.refused(Refusal::unknown_sender), 1U);
}

TEST_P(AStandardClient, IsAnsweredByAnAlertWithItsIdWhenItCloses) {
    Peer peer{id_of(GetParam())};
    ASSERT_TRUE(peer.connect(broker));
    ASSERT_EQ(ask(peer, peer.record_of(connect_as("a"))), connack);
    const auto answers = broker.take(place, peer.record_of({1, 0}, 3, 21));
    ASSERT_EQ(answers.size(), 1U);
    const auto read = peer.read(answers[0].octets);
    ASSERT_TRUE(read);
    EXPECT_EQ(read->type, 21);
    EXPECT_EQ(read->content, (Octets{1, 0}));
    EXPECT_EQ(broker.listener.clients().size(), 0U);
}

TEST_F(AtABroker, AClientThatWantsALongerIdIsServedWithoutAny) {
    Peer peer{id_of(33)};
    ASSERT_TRUE(peer.connect(broker));
    EXPECT_FALSE(peer.is_agreed());
    EXPECT_EQ(ask(peer, peer.record_of(connect_as("a"))), connack);
    EXPECT_TRUE(broker.take(other_place, peer.record_of(ping)).empty());
}

}  // namespace
}  // namespace romano::dtls::standard_ids_test
