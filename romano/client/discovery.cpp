#include "romano/client/discovery.h"

#include <algorithm>

#include "romano/client/gateway_address.h"
#include "romano/mqttsn/codec.h"
#include "romano/mqttsn/decode.h"

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
    if (frame->type == MsgType::advertise) {
        if (const auto m = mqttsn::decode_advertise(frame->body)) on_advertise(now, from, *m);
    } else if (frame->type == MsgType::gwinfo) {
        if (const auto m = mqttsn::decode_gwinfo(frame->body)) on_gwinfo(now, from, *m);
    } else if (frame->type == MsgType::searchgw) {
        if (const auto m = mqttsn::decode_searchgw(frame->body)) on_searchgw(now, *m);
    }
}

void Discovery::on_advertise(Instant now, const Endpoint& from, const mqttsn::Advertise& message) {
    note(now, message.gateway_id, from, std::chrono::seconds{message.duration_s});
}

/// A gateway's own GWINFO comes from its address; another client's says the address (6.1c). Either
/// ends the wish to answer (6.1e).
void Discovery::on_gwinfo(Instant now, const Endpoint& from, const mqttsn::Gwinfo& message) {
    answer_at_ = never;
    const Gateway* known = find(message.gateway_id);
    const Duration t_adv = known != nullptr ? known->t_adv : options_.t_adv;
    if (message.gateway_address.empty()) return note(now, message.gateway_id, from, t_adv);
    // Hearsay tells of a gateway, but is no sign of its life.
    if (known != nullptr) return;
    const auto address = read_gateway_address(message.gateway_address, options_.gateway_port);
    if (address) note(now, message.gateway_id, *address, t_adv);
}

/// Somebody else's search in our radius counts as our own (6.1d). One who knows a gateway answers
/// when no gateway does (6.1e).
void Discovery::on_searchgw(Instant now, const mqttsn::Searchgw& message) {
    if (is_searching() && message.radius == options_.radius) search_more_rarely(now);
    if (options_.answers_others && !gateways_.empty() && answer_at_ == never) {
        answer_at_ = now + random_.between(Duration::zero(), options_.t_gwinfo);
    }
}

void Discovery::note(Instant now, std::uint8_t id, const Endpoint& address, Duration t_adv) {
    const Gateway gateway{id, address, t_adv, now + t_adv * options_.n_adv};
    if (Gateway* known = find(id)) {
        *known = gateway;
    } else if (!gateways_.push_back(gateway)) {
        return;
    }
    search_at_ = never;
}

Gateway* Discovery::find(std::uint8_t id) {
    for (Gateway& gateway : gateways_) {
        if (gateway.id == id) return &gateway;
    }
    return nullptr;
}

void Discovery::forget_expired(Instant now) {
    for (std::size_t i = gateways_.size(); i > 0; --i) {
        if (gateways_[i - 1].expires <= now) gateways_.erase_at(i - 1);
    }
    if (gateways_.empty()) answer_at_ = never;
}

void Discovery::search_more_rarely(Instant now) {
    search_at_ = now + search_interval_;
    search_interval_ = std::min(search_interval_ * 2, options_.t_adv);
}

std::size_t Discovery::on_tick(Instant now, MutableBytes out) {
    forget_expired(now);
    if (search_at_ <= now) {
        search_more_rarely(now);
        return mqttsn::encode(mqttsn::Searchgw{options_.radius}, out);
    }
    if (answer_at_ <= now) {
        answer_at_ = never;
        const Gateway& gateway = gateways_[0];
        const auto address = write_gateway_address(gateway.address);
        return mqttsn::encode(mqttsn::Gwinfo{gateway.id, address}, out);
    }
    return 0;
}

Instant Discovery::next_wakeup() const {
    Instant next = std::min(search_at_, answer_at_);
    for (const Gateway& gateway : gateways_) next = std::min(next, gateway.expires);
    return next;
}

}  // namespace romano::client
