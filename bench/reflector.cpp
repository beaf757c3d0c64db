// The limit that a broker is measured against: it moves datagrams from publishers to subscribers
// and does nothing else that could be left out.
//
// One socket, recvmmsg and sendmmsg, octets forwarded from where they were received. A PUBLISH goes
// to the addresses behind its topic id; at QoS 1 and 2 each datagram is answered by the next one of
// its exchange, without remembering anything. So clients see a broker, as long as nothing gets
// lost, topics have one publisher, and ids are never in dispute.

#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "broker/net/endpoint_text.h"
#include "broker/net/socket_address.h"
#include "romano/mqttsn/codec.h"

namespace {

using namespace romano;
using mqttsn::MsgType;

constexpr const char* help = R"(romano_reflector ADDR:PORT

Moves datagrams from MQTT-SN publishers to their subscribers without being a broker: the limit that
romano_broker_bench measures brokers against. IPv4.

Example:
  romano_reflector 127.0.0.1:1883
)";

class Reflector {
public:
    explicit Reflector(int socket) : socket_(socket) {
        for (std::size_t i = 0; i < batch; ++i) {
            vectors_[i] = {buffers_[i].data(), buffers_[i].size()};
            received_[i].msg_hdr.msg_iov = &vectors_[i];
            received_[i].msg_hdr.msg_iovlen = 1;
            received_[i].msg_hdr.msg_name = &senders_[i];
        }
    }

    [[noreturn]] void run() {
        for (;;) {
            for (mmsghdr& header : received_) header.msg_hdr.msg_namelen = sizeof(sockaddr_in);
            const int count = ::recvmmsg(socket_, received_.data(), batch, MSG_WAITFORONE, nullptr);
            answers_used_ = 0;
            for (int i = 0; i < count; ++i) on_datagram(static_cast<std::size_t>(i));
            flush();
        }
    }

private:
    static constexpr std::size_t batch = 64;
    static constexpr std::size_t most_queued = 128;
    using Answer = std::array<std::uint8_t, 16>;

    void on_datagram(std::size_t slot) {
        const MutableBytes octets{buffers_[slot].data(), received_[slot].msg_len};
        if (octets.size() < 2 || octets[0] != octets.size()) return;  // the short form will do here
        const sockaddr_in& from = senders_[slot];
        switch (static_cast<MsgType>(octets[1])) {
            case MsgType::publish:
                if (octets.size() >= 7) on_publish(octets, from);
                break;
            case MsgType::pubrel:
                answer(octets, MsgType::pubcomp, from);
                break;
            case MsgType::pubrec:
                answer(octets, MsgType::pubrel, from);
                break;
            case MsgType::puback:
            case MsgType::pubcomp:
                break;
            default:
                on_set_up(octets, from);
                break;
        }
    }

    void on_publish(MutableBytes octets, const sockaddr_in& from) {
        const unsigned qos = octets[2] >> 5U & 3U;
        if (qos == 1) {  // topic id and message id stand as in PUBLISH
            Answer& puback = answers_[answers_used_++];
            puback = {7, static_cast<std::uint8_t>(MsgType::puback)};
            std::memcpy(&puback[2], &octets[3], 4);
            send({puback.data(), 7}, from);
        } else if (qos == 2) {
            Answer& pubrec = answers_[answers_used_++];
            pubrec = {4, static_cast<std::uint8_t>(MsgType::pubrec), octets[5], octets[6]};
            send({pubrec.data(), 4}, from);
        }
        const std::size_t topic = be16(octets, 3);
        if (topic >= subscribers_.size()) return;
        for (const sockaddr_in& subscriber : subscribers_[topic]) send(octets, subscriber);
    }

    /// The same octets with another message type: PUBREC, PUBREL and PUBCOMP hold the same.
    void answer(MutableBytes octets, MsgType type, const sockaddr_in& to) {
        octets[1] = static_cast<std::uint8_t>(type);
        send(octets, to);
    }

    void send(MutableBytes octets, const sockaddr_in& to) {
        if (queued_ == most_queued) flush();
        targets_[queued_] = to;
        out_vectors_[queued_] = {octets.data(), octets.size()};
        msghdr& header = out_[queued_++].msg_hdr;
        header = {};
        header.msg_name = &targets_[queued_ - 1];
        header.msg_namelen = sizeof(sockaddr_in);
        header.msg_iov = &out_vectors_[queued_ - 1];
        header.msg_iovlen = 1;
    }

    void flush() {
        std::size_t done = 0;
        while (done < queued_) {
            const int sent =
                ::sendmmsg(socket_, out_.data() + done, static_cast<unsigned>(queued_ - done), 0);
            done += sent > 0 ? static_cast<std::size_t>(sent) : 1;
        }
        queued_ = 0;
    }

    // --- once a client

    static bool is_same(const sockaddr_in& a, const sockaddr_in& b) {
        return a.sin_addr.s_addr == b.sin_addr.s_addr && a.sin_port == b.sin_port;
    }

    template <typename M>
    void reply(const M& message, const sockaddr_in& to) {
        Answer& octets = answers_[answers_used_++];
        send({octets.data(), mqttsn::encode(message, octets)}, to);
    }

    mqttsn::TopicId id_of(std::string_view name) {
        const auto next = static_cast<std::uint16_t>(ids_.size() + 1);
        const std::uint16_t id = ids_.emplace(name, next).first->second;
        if (subscribers_.size() <= id) subscribers_.resize(id + 1U);
        return mqttsn::TopicId{id};
    }

    void on_set_up(Bytes octets, const sockaddr_in& from) {
        const auto message = mqttsn::decode(octets);
        if (!message) return;
        if (std::holds_alternative<mqttsn::Connect>(*message)) {
            reply(mqttsn::Connack{mqttsn::ReturnCode::accepted}, from);
        } else if (const auto* wanted = std::get_if<mqttsn::Register>(&*message)) {
            reply(mqttsn::Regack{id_of(wanted->topic_name), wanted->msg_id,
                                 mqttsn::ReturnCode::accepted},
                  from);
        } else if (const auto* subscribe = std::get_if<mqttsn::Subscribe>(&*message)) {
            const mqttsn::TopicId id = id_of(subscribe->topic.name);
            auto& subscribers = subscribers_[static_cast<std::uint16_t>(id)];
            const auto same = [&](const sockaddr_in& other) { return is_same(other, from); };
            if (std::ranges::none_of(subscribers, same)) subscribers.push_back(from);
            reply(
                mqttsn::Suback{subscribe->qos, id, subscribe->msg_id, mqttsn::ReturnCode::accepted},
                from);
        } else if (std::holds_alternative<mqttsn::Pingreq>(*message)) {
            reply(mqttsn::Pingresp{}, from);
        } else if (std::holds_alternative<mqttsn::Disconnect>(*message)) {
            for (auto& subscribers : subscribers_) {
                std::erase_if(subscribers,
                              [&](const sockaddr_in& other) { return is_same(other, from); });
            }
            reply(mqttsn::Disconnect{}, from);
        }
    }

    int socket_;
    std::array<std::array<std::uint8_t, 2048>, batch> buffers_;
    std::array<sockaddr_in, batch> senders_;
    std::array<iovec, batch> vectors_;
    std::array<mmsghdr, batch> received_{};
    std::array<Answer, batch> answers_;
    std::size_t answers_used_ = 0;

    std::array<sockaddr_in, most_queued> targets_;
    std::array<iovec, most_queued> out_vectors_;
    std::array<mmsghdr, most_queued> out_{};
    std::size_t queued_ = 0;

    std::map<std::string, std::uint16_t, std::less<>> ids_;
    std::vector<std::vector<sockaddr_in>> subscribers_;  // by topic id
};

int serve(const std::string& text) {
    const auto at = net::parse_endpoint(text);
    if (!at || at->family != Endpoint::Family::ipv4) {
        std::fprintf(stderr, "romano_reflector: `%s` is no IPv4 address and port\n", text.c_str());
        return 2;
    }
    const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    const int room = 8 * 1024 * 1024;
    if (::setsockopt(socket, SOL_SOCKET, SO_RCVBUFFORCE, &room, sizeof room) != 0) {
        (void)::setsockopt(socket, SOL_SOCKET, SO_RCVBUF, &room, sizeof room);
    }
    const int whole = IP_PMTUDISC_DO;  // as the broker's sockets
    (void)::setsockopt(socket, IPPROTO_IP, IP_MTU_DISCOVER, &whole, sizeof whole);
    const net::SocketAddress address = net::to_socket_address(*at);
    if (::bind(socket, &address.any, address.size) != 0) {
        std::fprintf(stderr, "romano_reflector: cannot serve %s: %s\n", text.c_str(),
                     std::strerror(errno));
        return 2;
    }
    std::printf("romano_reflector: serving %s\n", text.c_str());
    std::fflush(stdout);
    static Reflector reflector{socket};
    reflector.run();
}

}  // namespace

int main(int argc, char** argv) {
    const std::string argument = argc == 2 ? argv[1] : "--help";
    if (argument == "--help") {
        std::fputs(help, stdout);
        return argc == 2 ? 0 : 2;
    }
    return serve(argument);
}
