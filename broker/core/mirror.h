// A copy of what a broker is the home of, made by applying its log event by event.
//
// After the same events two mirrors are equal, and equal to the home's own images (same_state).
// When the home dies its heir goes on from here. Messages of other logs arrive by other ways: a
// delivery names its message by position, and resolve() fills it in when the message is known.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "broker/core/cursors.h"
#include "broker/core/log_event.h"
#include "broker/core/session_image.h"

namespace romano::broker {

class Mirror {
public:
    /// Of this log, from its first event on.
    explicit Mirror(LogId log) : log_(log) {}

    // --- from a snapshot, before the first event
    void put(const SessionImage& image);
    void erase(std::string_view client_id);
    /// These are the home's sessions as of that event; and how far it had worked through others'
    /// logs.
    void begin_after(Seq as_of, std::span<const LogPosition> cursors);

    // --- event by event
    /// The event after the last one; `seq` says which, and must be applied() + 1.
    void apply(Seq seq, const LogEvent& event);

    /// A message of any log became known. Cheap when no delivery waits for it.
    void resolve(const MessagePtr& message);
    /// The messages that deliveries still wait for.
    [[nodiscard]] std::vector<LogPosition> unresolved() const;
    [[nodiscard]] bool is_any_unresolved() const { return !waiting_.empty(); }
    [[nodiscard]] bool is_unresolved(const LogPosition& position) const {
        return waiting_.contains(position);
    }

    [[nodiscard]] LogId log() const { return log_; }
    [[nodiscard]] Seq applied() const { return applied_; }
    /// How far the home says that it worked through each peer's log; by log.
    [[nodiscard]] const std::vector<LogPosition>& cursors() const { return cursors_.all(); }
    [[nodiscard]] Seq cursor(const LogId& log) const { return cursors_.at(log); }
    /// See BrokerCore::forget_logs.
    void forget_logs(const std::function<bool(const LogId&)>& are_over) {
        cursors_.forget(are_over);
    }

    [[nodiscard]] std::size_t size() const { return sessions_.size(); }
    [[nodiscard]] bool contains(std::string_view client_id) const;
    /// Null when it is not here.
    [[nodiscard]] const SessionHeader* header(std::string_view client_id) const;
    /// As it is here: `worked_through` is that of the last SessionPut. Null when it is not here;
    /// valid until the next event.
    [[nodiscard]] const SessionImage* session(std::string_view client_id) const;
    [[nodiscard]] std::optional<SessionImage> image(std::string_view client_id) const;
    [[nodiscard]] std::vector<SessionImage> images() const;  // by client id
    /// Calls `look(const SessionImage&)` with each as it is here, in no order: `worked_through` is
    /// that of the last SessionPut.
    template <typename Look>
    void visit(Look&& look) const {
        for (const auto& [client_id, image] : sessions_) look(image);
    }

private:
    struct TextHash {
        using is_transparent = void;
        std::size_t operator()(std::string_view text) const {
            return std::hash<std::string_view>{}(text);
        }
    };

    void on(const SessionPut& event);
    void on(const SessionChanged& event);
    void on(const SessionErased& event);
    void on(const SessionMoved& event);
    static void on(const Sealed&) {}
    void on(const WillChanged& event);
    void on(const Subscribed& event);
    void on(const Unsubscribed& event);
    void on(const TopicBound& event);
    void on(const Published& event);
    void on(const Routed& event);
    void on(const Cursor& event);
    void on(const DeliveryStarted& event);
    void on(const DeliveryReleased& event);
    void on(const DeliveryEnded& event);
    void on(const PublishReleased& event);

    [[nodiscard]] SessionImage* find(std::string_view client_id);
    void queue(const LogPosition& position, const MessagePtr& message, const Route& route);
    [[nodiscard]] SessionImage completed(const SessionImage& image) const;

    LogId log_;
    Seq applied_ = 0;
    Cursors cursors_;
    std::unordered_map<ClientId, SessionImage, TextHash, std::equal_to<>> sessions_;
    std::unordered_map<LogPosition, std::vector<ClientId>, LogPositionHash> waiting_;
};

}  // namespace romano::broker
