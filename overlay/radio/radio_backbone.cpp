#include "overlay/radio/radio_backbone.h"

#include <algorithm>
#include <utility>

namespace romano::radio {
namespace {

constexpr std::size_t piece_octets = 1'000;  // 6LoWPAN's packets have 1280 octets at most
constexpr double margin_db = 3;              // above the strength at which half of the frames come

}  // namespace

RadioBackbone::RadioBackbone(sim::EventQueue& events, const RadioModel& model,
                             std::vector<BackboneRadio> radios, std::size_t queue,
                             Transmit transmit)
    : events_(events),
      model_(model),
      radios_(std::move(radios)),
      queue_most_(queue),
      transmit_(std::move(transmit)),
      queues_(radios_.size()) {}

std::size_t RadioBackbone::number_of(sim::Node broker) const {
    const auto found = std::ranges::find(radios_, broker, &BackboneRadio::broker);
    return static_cast<std::size_t>(found - radios_.begin());
}

void RadioBackbone::send(sim::Node from, std::optional<sim::Node> to, std::size_t octets,
                         Arrived arrived, Left left) {
    const std::size_t radio = number_of(from);
    auto& queue = queues_[radio];
    const std::size_t pieces = std::max<std::size_t>(1, (octets + piece_octets - 1) / piece_octets);
    // A long one alone may be longer than the queue.
    if (!queue.empty() && queue.size() + pieces > queue_most_) {
        ++lost_;
        events_.after(Duration{0}, std::move(left));
        return;
    }
    const bool was_idle = queue.empty();
    const auto message =
        std::make_shared<Message>(Message{pieces, pieces, std::move(arrived), std::move(left), {}});
    const auto receiver = to ? std::optional{number_of(*to)} : std::nullopt;
    for (std::size_t i = 0; i < pieces; ++i) {
        queue.push_back({receiver, std::min(octets - i * piece_octets, piece_octets), message});
    }
    if (was_idle) transmit_next(radio);
}

void RadioBackbone::transmit_next(std::size_t radio) {
    const auto& queue = queues_[radio];
    if (queue.empty()) return;
    const Piece& piece = queue.front();
    transmit_(radio, piece.to, std::vector<std::uint8_t>(piece.octets, 'x'));
}

void RadioBackbone::on_ready(std::size_t radio) {
    const auto message = std::move(queues_[radio].front().message);
    queues_[radio].pop_front();
    if (--message->waiting == 0) events_.after(Duration{0}, std::move(message->left));
    transmit_next(radio);
}

/// The sender does not begin its next piece before this one is here or given up. The receiver may
/// answer, but not while the channel is in the midst of its own event.
void RadioBackbone::on_received(std::size_t at, std::size_t from) {
    const auto& queue = queues_[from];
    if (queue.empty()) return;
    const auto message = queue.front().message;
    if (++message->pieces_at[at] < message->pieces) return;
    events_.after(Duration{0},
                  [message, broker = radios_[at].broker] { message->arrived(broker); });
}

bool RadioBackbone::reaches(sim::Node from, sim::Node to) const {
    const double metres = distance_m(place(number_of(from)), place(number_of(to)));
    return mean_dbm(model_, metres) >= model_.half_lost_dbm + margin_db;
}

}  // namespace romano::radio
