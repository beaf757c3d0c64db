#include "overlay/dds/later_life.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

#include "overlay/dds/listener.h"
#include "overlay/dds/peer_writers.h"

namespace romano::dds {

LaterLife::LaterLife(boost::asio::io_context& io, const Entity& participant,
                     const broker::LogId& self, OnKnown on_known)
    : self_(self),
      on_known_(std::move(on_known)),
      wakeup_(std::make_shared<Wakeup>(io, [this] { look(); })),
      writers_(dds_create_reader(participant.handle(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr,
                                 ringing(*wakeup_).get()),
               "reader of the DDS topic that names writers") {}

void LaterLife::look() const {
    constexpr std::size_t most_at_once = 16;
    std::uint64_t latest = self_.incarnation;
    for (;;) {
        std::array<void*, most_at_once> writers{};  // DDS lends them
        std::array<dds_sample_info_t, most_at_once> infos{};
        const dds_return_t taken =
            dds_take(writers_.handle(), writers.data(), infos.data(), most_at_once, most_at_once);
        if (taken <= 0) break;
        for (std::size_t i = 0; i < static_cast<std::size_t>(taken); ++i) {
            if (!infos[i].valid_data) continue;  // it is gone
            const auto& writer = *static_cast<const dds_builtintopic_endpoint_t*>(writers[i]);
            const auto addressee = addressee_of(writer.topic_name);
            if (addressee && addressee->broker == self_.broker) {
                latest = std::max(latest, addressee->incarnation);
            }
        }
        dds_return_loan(writers_.handle(), writers.data(), taken);
    }
    if (latest > self_.incarnation) on_known_(latest);
}

}  // namespace romano::dds
