#include "bench/mosquitto_clients.h"

#include <mosquitto.h>
#include <sys/epoll.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>

#include "broker/net/clock.h"
#include "experiments/load/ready_sockets.h"

namespace romano::bench {

using namespace std::chrono_literals;

struct MosquittoClients::Client {
    MosquittoClients& all;
    Number number;
    std::vector<std::uint32_t> to_subscribe;
    mosquitto* handle = nullptr;
    bool wants_to_write = false;

    Client(MosquittoClients& all_clients, Number own_number, std::vector<std::uint32_t> topics)
        : all(all_clients), number(own_number), to_subscribe(std::move(topics)) {
        handle = ::mosquitto_new(("load-" + std::to_string(number)).c_str(), true, this);
        if (handle == nullptr) throw std::runtime_error("no memory for a client");
        ::mosquitto_int_option(handle, MOSQ_OPT_TCP_NODELAY, 1);
        ::mosquitto_max_inflight_messages_set(handle, 0);
        ::mosquitto_connect_callback_set(handle, [](mosquitto*, void* self, int code) {
            auto& client = *static_cast<Client*>(self);
            if (code != 0) {
                client.all.listener_->on_trouble(client.number, "mosquitto refused a connection");
            } else {
                client.all.subscribe_next(client);
            }
        });
        ::mosquitto_subscribe_callback_set(handle,
                                           [](mosquitto*, void* self, int, int, const int*) {
                                               auto& client = *static_cast<Client*>(self);
                                               client.all.subscribe_next(client);
                                           });
        ::mosquitto_message_callback_set(
            handle, [](mosquitto*, void* self, const mosquitto_message* message) {
                auto& client = *static_cast<Client*>(self);
                const Bytes payload{static_cast<const std::uint8_t*>(message->payload),
                                    static_cast<std::size_t>(message->payloadlen)};
                client.all.listener_->on_message(net::now(), client.number, payload, false);
            });
        ::mosquitto_publish_callback_set(handle, [](mosquitto*, void* self, int id) {
            auto& client = *static_cast<Client*>(self);
            if (client.all.plan_.qos == mqttsn::Qos::at_most_once) return;
            client.all.listener_->on_published(net::now(), client.number,
                                               static_cast<PublishId>(id), true);
        });
    }
    Client(const Client&) = delete;
    Client& operator=(const Client&) = delete;
    ~Client() { ::mosquitto_destroy(handle); }

    void will_write() {
        if (!std::exchange(wants_to_write, true)) all.to_write_.push_back(this);
    }
};

MosquittoClients::MosquittoClients(const experiments::LoadPlan& plan, std::string host, int port)
    : plan_(plan), host_(std::move(host)), port_(port), epoll_(::epoll_create1(EPOLL_CLOEXEC)) {
    ::mosquitto_lib_init();
    for (Number number = 0; number < plan.clients(); ++number) {
        clients_.push_back(std::make_unique<Client>(*this, number, plan.heard_by(number)));
    }
}

MosquittoClients::~MosquittoClients() {
    clients_.clear();
    ::close(epoll_);
    ::mosquitto_lib_cleanup();
}

void MosquittoClients::join(Number number) {
    connect(*clients_[number]);
}

/// The first one comes before mosquitto listens.
void MosquittoClients::connect(Client& client) {
    const Instant deadline = net::now() + 20s;
    while (::mosquitto_connect(client.handle, host_.c_str(), port_, 60) != MOSQ_ERR_SUCCESS) {
        if (net::now() > deadline) {
            listener_->on_trouble(client.number, "mosquitto does not accept connections");
            return;
        }
        std::this_thread::sleep_for(5ms);
    }
    epoll_event event{.events = EPOLLIN, .data = {.u32 = client.number}};
    ::epoll_ctl(epoll_, EPOLL_CTL_ADD, ::mosquitto_socket(client.handle), &event);
    client.will_write();
}

void MosquittoClients::subscribe_next(Client& client) {
    if (client.to_subscribe.empty()) {
        listener_->on_joined(client.number);
        return;
    }
    const std::string topic = plan_.topic_name(client.to_subscribe.back());
    client.to_subscribe.pop_back();
    ::mosquitto_subscribe(client.handle, nullptr, topic.c_str(), static_cast<int>(plan_.qos));
    client.will_write();
}

std::optional<experiments::LoadClients::PublishId> MosquittoClients::publish(Instant, Number number,
                                                                             std::uint32_t topic,
                                                                             Bytes payload) {
    Client& client = *clients_[number];
    int id = 0;
    const int result = ::mosquitto_publish(client.handle, &id, plan_.topic_name(topic).c_str(),
                                           static_cast<int>(payload.size()), payload.data(),
                                           static_cast<int>(plan_.qos), false);
    if (result != MOSQ_ERR_SUCCESS) return std::nullopt;
    client.will_write();
    return static_cast<PublishId>(id);
}

void MosquittoClients::turn(Instant until) {
    write_rest();
    std::array<epoll_event, 64> room{};
    for (const epoll_event& event : experiments::wait_for_sockets(epoll_, until, room)) {
        serve(*clients_[event.data.u32], true);
    }
    write_rest();
}

/// libmosquitto reads one packet at a time; all that has come is read before the next wait.
void MosquittoClients::serve(Client& client, bool readable) {
    const int socket = ::mosquitto_socket(client.handle);
    int waiting = readable ? 1 : 0;
    while (waiting > 0) {
        if (::mosquitto_loop_read(client.handle, 1) != MOSQ_ERR_SUCCESS) {
            ::epoll_ctl(epoll_, EPOLL_CTL_DEL, socket, nullptr);
            listener_->on_trouble(client.number, "mosquitto ended a connection");
            return;
        }
        if (::ioctl(socket, FIONREAD, &waiting) != 0) return;
    }
}

void MosquittoClients::write_rest() {
    for (std::size_t i = 0; i < to_write_.size(); ++i) {
        Client& client = *to_write_[i];
        client.wants_to_write = false;
        while (::mosquitto_want_write(client.handle) &&
               ::mosquitto_loop_write(client.handle, 1) == MOSQ_ERR_SUCCESS) {
        }
        // The socket is full: once more in the next turn.
        if (::mosquitto_want_write(client.handle)) client.wants_to_write = true;
    }
    std::erase_if(to_write_, [](const Client* client) { return !client->wants_to_write; });
}

void MosquittoClients::leave() {
    for (const auto& client : clients_) ::mosquitto_disconnect(client->handle);
}

}  // namespace romano::bench
