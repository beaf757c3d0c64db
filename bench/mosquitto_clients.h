// MQTT clients over TCP for the same load, by libmosquitto: the yardstick that people know.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "experiments/load/load_clients.h"
#include "experiments/load/load_plan.h"

namespace romano::bench {

class MosquittoClients : public experiments::LoadClients {
public:
    MosquittoClients(const experiments::LoadPlan& plan, std::string host, int port);
    ~MosquittoClients() override;

    void attach(Listener& listener) override { listener_ = &listener; }
    void join(Number client) override;
    std::optional<PublishId> publish(Instant, Number client, std::uint32_t topic,
                                     Bytes payload) override;
    void turn(Instant until) override;
    void leave() override;
    [[nodiscard]] std::uint64_t retransmissions() const override { return 0; }
    [[nodiscard]] std::uint64_t dropped_here() const override { return 0; }

private:
    struct Client;

    void connect(Client& client);
    void subscribe_next(Client& client);
    void serve(Client& client, bool readable);
    void write_rest();

    const experiments::LoadPlan& plan_;
    std::string host_;
    int port_;
    int epoll_ = -1;
    std::vector<std::unique_ptr<Client>> clients_;
    std::vector<Client*> to_write_;
    Listener* listener_ = nullptr;
};

}  // namespace romano::bench
