#include "romano/keys/client_speech.h"

#include <utility>
#include <vector>

#include "romano/dtls/client_link.h"

namespace romano::keys {
namespace {

class ByPackets final : public ClientSpeech {
public:
    ByPackets(std::shared_ptr<ClientPackets> key, Put put)
        : key_(std::move(key)), put_(std::move(put)) {}

    void send(Bytes message) override {
        const Bytes packet = key_->seal(message);
        if (!packet.empty()) put_(packet);
    }
    Bytes open(Bytes datagram) override {
        packet_.assign(datagram.begin(), datagram.end());
        return key_->open(packet_);
    }

private:
    std::shared_ptr<ClientPackets> key_;
    Put put_;
    std::vector<std::uint8_t> packet_;  // as long as its message is read
};

class ByDtls final : public ClientSpeech {
public:
    ByDtls(std::shared_ptr<ClientPackets> key, Put put)
        : key_(std::move(key)), link_(key_->client_id(), key_->pre_shared_key(), std::move(put)) {}
    ~ByDtls() override { link_.close(); }

    void send(Bytes message) override { link_.send(message); }
    Bytes open(Bytes datagram) override { return link_.open(datagram); }
    std::optional<Duration> due_in() const override { return link_.due_in(); }
    void on_time() override { link_.on_time(); }
    std::uint64_t handshakes() const override { return link_.handshakes(); }

private:
    std::shared_ptr<ClientPackets> key_;  // its place is not free before this is gone
    dtls::ClientLink link_;
};

}  // namespace

std::unique_ptr<ClientSpeech> speak(std::shared_ptr<ClientPackets> key, ClientSpeech::Put put) {
    if (key->speech() == Speech::dtls) {
        return std::make_unique<ByDtls>(std::move(key), std::move(put));
    }
    return std::make_unique<ByPackets>(std::move(key), std::move(put));
}

}  // namespace romano::keys
