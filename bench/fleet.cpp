#include "bench/fleet.h"

#include <array>
#include <cstdio>
#include <fstream>
#include <memory>
#include <utility>

#include "romano/dtls/client_link.h"
#include "romano/protection/robot_end.h"

namespace romano::bench {
namespace {

/// A ROMANO id.
std::string name_of(std::uint32_t client) {
    std::array<char, 9> text{};
    std::snprintf(text.data(), text.size(), "%08x", client);
    return text.data();
}

class Packets final : public keys::ClientSpeech {
public:
    Packets(const protection::RobotKey& key, std::string_view id, Put put)
        : keys_(protection::direction_keys(key)), end_(keys_, id, 0), put_(std::move(put)) {}

    void send(Bytes message) override {
        if (const auto bound = end_.reserve().to_store()) end_.reserve().on_stored(*bound);
        out_.resize(message.size() + protection::most_overhead);
        const std::size_t size = end_.seal(message, out_);
        if (size != 0) put_(Bytes{out_}.first(size));
    }
    Bytes open(Bytes datagram) override {
        in_.assign(datagram.begin(), datagram.end());
        return end_.open(in_);
    }

private:
    protection::DirectionKeys keys_;
    protection::RobotEnd end_;
    Put put_;
    std::vector<std::uint8_t> out_;
    std::vector<std::uint8_t> in_;
};

/// Without a Connection ID, as standard clients are.
class Dtls final : public keys::ClientSpeech {
public:
    Dtls(const protection::RobotKey& key, const std::string& id, Put put)
        : link_(id, protection::pre_shared_key(key), std::move(put), dtls::ClientEnd::Wants::none) {
    }
    ~Dtls() override { link_.close(); }

    void send(Bytes message) override { link_.send(message); }
    Bytes open(Bytes datagram) override { return link_.open(datagram); }
    std::uint64_t handshakes() const override { return link_.handshakes(); }

private:
    dtls::ClientLink link_;
};

}  // namespace

const char* scheme_of(Endpoint::Packets packets) {
    switch (packets) {
        case Endpoint::Packets::sealed:
            return "protected://";
        case Endpoint::Packets::dtls:
            return "dtls://";
        case Endpoint::Packets::plain:
            break;
    }
    return "";
}

Fleet::Fleet(const std::filesystem::path& folder, const std::vector<std::string>& brokers,
             std::uint32_t clients)
    : folder_(folder), keys_(folder) {
    std::filesystem::remove_all(folder);
    keys::Names names{.brokers = brokers, .robots = {}, .operators = {}};
    for (std::uint32_t client = 0; client < clients; ++client) {
        names.robots.push_back(name_of(client));
    }
    keys_.add(names);
    table_ = keys_.clients();
    std::ofstream(folder_ / "rights")
        << "group robots\ntopic readwrite #\ngroup plain\ntopic readwrite #\n";
}

std::vector<std::string> Fleet::broker_arguments(const std::string& broker) const {
    return {"--keys", keys_.broker_folder(broker), "--rights", folder_ / "rights"};
}

std::filesystem::path Fleet::key_file(std::uint32_t client) const {
    return keys_.own_file(name_of(client), keys::Role::robot);
}

experiments::KeyedClient Fleet::client(std::uint32_t number, Endpoint::Packets packets,
                                       keys::ClientSpeech::Put put) const {
    std::string id = name_of(number);
    const protection::RobotKey key = keys::key_of(table_.at(id), id);
    std::unique_ptr<keys::ClientSpeech> speech;
    if (packets == Endpoint::Packets::dtls) {
        speech = std::make_unique<Dtls>(key, id, std::move(put));
    } else {
        speech = std::make_unique<Packets>(key, id, std::move(put));
    }
    return {std::move(id), std::move(speech)};
}

}  // namespace romano::bench
