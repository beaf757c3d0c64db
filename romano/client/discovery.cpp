#include "romano/client/discovery.h"

#include <algorithm>

#include "romano/client/gateway_address.h"
#include "romano/mqttsn/frame.h"

namespace romano::client {

using mqttsn::MsgType;

void Discovery::search(Instant now) {
    search_interval_ = options_.t_searchgw;
    search_at_ = now + random_.between(Duration::zero(), options_.t_searchgw);
}

void Discovery::on_datagram(Instant now, const Endpoint& from, Bytes datagram) {
    forget_expired(now);
    const auto frame = mqttsn::decode_frame(datagram);
    if (!frame) return;
    const auto message = mqttsn::read_body(frame->type, frame->body);
    if (!message) return;
    if (frame->type == MsgType::advertise) {
        const std::chrono::seconds t_adv{static_cast<std::uint16_t>(message->msg_id)};
        note(now, message->flags, from, t_adv);
    } else if (frame->type == MsgType::gwinfo) {
        on_gwinfo(now, from, *message);
    } else if (frame->type == MsgType::searchgw && is_searching() &&
               message->flags == options_.radius) {
        search_more_rarely(now);  // somebody else's search in our radius counts as our own (6.1d)
    }
}

/// A gateway's own GWINFO comes from its address; another client's says the address (6.1c).
void Discovery::on_gwinfo(Instant now, const Endpoint& from, const mqttsn::Body& message) {
    const std::uint8_t id = message.flags;
    const Gateway* known = find(id);
    if (message.rest.empty()) {
        return note(now, id, from, known != nullptr ? known->t_adv : options_.t_adv);
    }
    // Hearsay tells of a gateway, but is no sign of its life.
    if (known != nullptr) return;
    const auto address = read_gateway_address(message.rest, options_.gateway_port);
    if (address) note(now, id, *address, options_.t_adv);
}

void Discovery::note(Instant now, std::uint8_t id, const Endpoint& address, Duration t_adv) {
    Gateway* gateway = find(id);
    if (gateway == nullptr) gateway = gateways_.add();
    if (gateway == nullptr) return;
    gateway->id = id;
    gateway->address = address;
    gateway->t_adv = t_adv;
    gateway->expires = now + t_adv * options_.n_adv;
    search_at_ = never;
}

Gateway* Discovery::find(std::uint8_t id) {
    for (Gateway& gateway : gateways_) {
        if (gateway.id == id) return &gateway;
    }
    return nullptr;
}

void Discovery::forget_expired(Instant now) {
    gateways_.erase_if([now](const Gateway& gateway) { return gateway.expires <= now; });
}

void Discovery::search_more_rarely(Instant now) {
    search_at_ = now + search_interval_;
    search_interval_ = std::min(search_interval_ * 2, options_.t_adv);
}

std::size_t Discovery::on_tick(Instant now, MutableBytes out) {
    forget_expired(now);
    if (now < search_at_) return 0;
    search_more_rarely(now);
    return mqttsn::write_message(MsgType::searchgw, {.flags = options_.radius}, out);
}

Instant Discovery::next_wakeup() const {
    Instant next = search_at_;
    for (const Gateway& gateway : gateways_) next = std::min(next, gateway.expires);
    return next;
}

}  // namespace romano::client
