// Receivers at peers whose queues fill up, as their homes' logs tell: who publishes here for them
// goes at their pace (broker/core, "When a receiver is slow"), as beside them.
//
// Only who takes messages counts: a message is on its way to it, and one was done not long ago. A
// receiver keeps that when its home dies or hands it on: while it moves it takes nothing, and its
// queue would be filled in no time.
#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "broker/core/mirror.h"
#include "overlay/cluster/messages.h"
#include "romano/base/time.h"

namespace romano::cluster {

class SlowReceivers {
public:
    static constexpr std::size_t most_heeded = 1024;

    /// The next event of a peer's log, before its mirror applies it. Receivers with more than
    /// `many` messages waiting are heeded.
    void on_event(Instant now, const broker::Mirror& sessions, const broker::LogEvent& event,
                  std::size_t many);
    /// It has come here.
    void forget(const broker::ClientId& client) { receivers_.erase(client); }
    /// Those of a peer of which nothing is known any more.
    void forget(BrokerId home);

    /// What waits in the longest queue of those that want the topic at QoS 1 or 2 and were done
    /// with a message after `since`; 0 when there is none.
    [[nodiscard]] std::size_t longest_queue(std::string_view topic, Instant since) const;

private:
    struct Receiver {
        BrokerId home;
        std::size_t waiting = 0;
        Instant last_taken{};
        std::vector<std::string> filters{};  // granted QoS 1 or 2

        void wants(const broker::Subscription& subscription);
        void wants_no_more(const std::string& filter) { std::erase(filters, filter); }
    };

    void look_at(Instant now, BrokerId home, const broker::SessionImage& image, std::size_t many);
    void make_room();
    [[nodiscard]] Receiver* find(BrokerId home, const broker::ClientId& client);

    std::map<broker::ClientId, Receiver> receivers_;
};

}  // namespace romano::cluster
