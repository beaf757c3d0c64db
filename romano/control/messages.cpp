#include "romano/control/messages.h"

#include <algorithm>
#include <iterator>

namespace romano::control {
namespace {

enum class Kind : std::uint8_t {
    ask = 1,
    open,
    renew,
    end,
    report,
    invite,
    answer,
    sample,
    command,
    bye,
};

constexpr std::uint8_t ends_then_flag = 0x80;

/// Reads fields one after the other; beyond the end, or a value that may not be, it has failed and
/// what it gives is of no use.
class Reader {
public:
    explicit Reader(Bytes octets) : octets_(octets) {}

    std::uint32_t number(std::size_t size) {
        std::uint32_t value = 0;
        for (const std::uint8_t octet : take(size)) value = (value << 8U) | octet;
        return value;
    }
    std::uint8_t u8() { return static_cast<std::uint8_t>(number(1)); }
    std::uint16_t u16() { return static_cast<std::uint16_t>(number(2)); }
    std::uint32_t u32() { return number(4); }
    template <typename Enum>
    Enum up_to(Enum last) {
        const std::uint8_t value = u8();
        if (value > static_cast<std::uint8_t>(last)) has_failed_ = true;
        return static_cast<Enum>(value);
    }
    RomanoId id() {
        const auto id = RomanoId::parse(as_text(take(RomanoId::size)));
        if (!id) has_failed_ = true;
        return id.value_or(RomanoId{});
    }
    Channel channel() { return Channel{u8()}; }
    Session session() { return Session{u32()}; }
    Reason reason() { return up_to(Reason::not_allowed); }
    Bytes rest(std::size_t most) {
        if (octets_.size() > most) has_failed_ = true;
        return take(octets_.size());
    }
    /// All was there, and nothing more.
    [[nodiscard]] bool is_done() const { return !has_failed_ && octets_.empty(); }

private:
    Bytes take(std::size_t size) {
        if (size > octets_.size()) {
            has_failed_ = true;
            size = 0;
        }
        const Bytes taken = octets_.first(size);
        octets_ = octets_.subspan(size);
        return taken;
    }

    Bytes octets_;
    bool has_failed_ = false;
};

class Writer {
public:
    Writer(MutableBytes out, Kind kind) : out_(out) {
        u8(data_type);
        u8(0);
        u8(static_cast<std::uint8_t>(kind));
    }
    void u8(std::uint8_t value) {
        if (size_ < out_.size()) out_[size_] = value;
        ++size_;
    }
    void u16(std::uint16_t value) {
        u8(static_cast<std::uint8_t>(value >> 8U));
        u8(static_cast<std::uint8_t>(value & 0xFFU));
    }
    void u32(std::uint32_t value) {
        u16(static_cast<std::uint16_t>(value >> 16U));
        u16(static_cast<std::uint16_t>(value & 0xFFFFU));
    }
    void octets(Bytes octets) {
        for (const std::uint8_t octet : octets) u8(octet);
    }
    void id(const RomanoId& id) { octets(as_octets(id.text())); }
    template <typename Enum>
    void code(Enum value) {
        u8(static_cast<std::uint8_t>(value));
    }
    void session(Session session) { u32(static_cast<std::uint32_t>(session)); }
    [[nodiscard]] std::size_t finish() {
        if (size_ > out_.size()) return 0;
        out_[1] = static_cast<std::uint8_t>(size_);
        return size_;
    }

private:
    MutableBytes out_;
    std::size_t size_ = 0;
};

// The fields of a braced list are read in their order.

Open open_in(Reader& in) {
    Open open{.channel = in.channel(),
              .ticket = in.session(),
              .asker = in.id(),
              .controller = in.id(),
              .law = Law{in.u16()},
              .period_ms = in.u16(),
              .deadline_ms = in.u16(),
              .lease_s = in.u16(),
              .fallback = {},
              .ends_then = false,
              .parameters = {}};
    const std::uint8_t fallback = in.u8();
    open.ends_then = (fallback & ends_then_flag) != 0;
    open.fallback = static_cast<Fallback>(fallback & ~ends_then_flag);
    open.parameters = in.rest(most_parameters);
    return open;
}

Report report_in(Reader& in) {
    return {.channel = in.channel(),
            .session = in.session(),
            .plant = in.id(),
            .controller = in.id(),
            .state = in.up_to(State::controlled),
            .reason = in.reason(),
            .counters = {.samples = in.u32(),
                         .accepted = in.u32(),
                         .late = in.u32(),
                         .repeated = in.u32(),
                         .foreign = in.u32(),
                         .falls = in.u32()},
            .ages = {.last = in.u32(),
                     .least = in.u32(),
                     .smoothed = in.u32(),
                     .greatest = in.u32(),
                     .jitter = in.u32()}};
}

Invite invite_in(Reader& in) {
    return {.session = in.session(),
            .plant = in.id(),
            .channel = in.channel(),
            .law = Law{in.u16()},
            .period_ms = in.u16(),
            .deadline_ms = in.u16(),
            .parameters = in.rest(most_parameters)};
}

std::optional<Message> body_in(Kind kind, Reader& in) {
    switch (kind) {
        case Kind::ask:
            return Ask{.channel = in.channel(), .asker = in.id()};
        case Kind::open: {
            const Open open = open_in(in);
            if (open.fallback > Fallback::own_law) return std::nullopt;
            return open;
        }
        case Kind::renew:
            return Renew{.session = in.session(), .asker = in.id()};
        case Kind::end:
            return End{.session = in.session(), .asker = in.id()};
        case Kind::report:
            return report_in(in);
        case Kind::invite:
            return invite_in(in);
        case Kind::answer:
            return Answer{.session = in.session(), .reason = in.reason()};
        case Kind::sample:
            return Sample{.session = in.session(),
                          .sequence = in.u32(),
                          .tick = in.u32(),
                          .age = in.u16(),
                          .value = in.rest(most_value)};
        case Kind::command:
            return Command{.session = in.session(),
                           .sequence = in.u32(),
                           .tick = in.u32(),
                           .value = in.rest(most_value)};
        case Kind::bye:
            return Bye{.session = in.session(), .reason = in.reason()};
    }
    return std::nullopt;
}

}  // namespace

std::string_view name_of(State state) {
    constexpr std::string_view names[] = {"free", "inviting", "waiting", "controlled"};
    return names[static_cast<std::size_t>(state)];
}

std::string_view name_of(Reason reason) {
    constexpr std::string_view names[] = {
        "none",
        "the ticket is not the channel's",
        "the plant has no such channel",
        "the channel is in a loop",
        "the plant finds the settings impossible",
        "the controller answered no invitation",
        "the controller has no such law, or cannot use these parameters",
        "the controller has no place left",
        "the controller has a loop of that session",
        "ended by a node",
        "the lease is over",
        "it fell back, and was told to end then",
        "the plant has no such loop",
        "the robot itself says no",
    };
    static_assert(std::size(names) == static_cast<std::size_t>(Reason::not_allowed) + 1);
    return names[static_cast<std::size_t>(reason)];
}

std::optional<Message> decode(Bytes message) {
    if (message.size() < 3 || !is_of_a_loop(message) || message[1] != message.size()) {
        return std::nullopt;
    }
    Reader in{message.subspan(3)};
    const auto body = body_in(static_cast<Kind>(message[2]), in);
    if (!in.is_done()) return std::nullopt;
    return body;
}

std::size_t encode(const Ask& m, MutableBytes out) {
    Writer to{out, Kind::ask};
    to.code(m.channel);
    to.id(m.asker);
    return to.finish();
}

std::size_t encode(const Open& m, MutableBytes out) {
    if (m.parameters.size() > most_parameters) return 0;
    Writer to{out, Kind::open};
    to.code(m.channel);
    to.session(m.ticket);
    to.id(m.asker);
    to.id(m.controller);
    to.u16(static_cast<std::uint16_t>(m.law));
    to.u16(m.period_ms);
    to.u16(m.deadline_ms);
    to.u16(m.lease_s);
    const unsigned flag = m.ends_then ? ends_then_flag : 0U;
    to.u8(static_cast<std::uint8_t>(static_cast<unsigned>(m.fallback) | flag));
    to.octets(m.parameters);
    return to.finish();
}

std::size_t encode(const Renew& m, MutableBytes out) {
    Writer to{out, Kind::renew};
    to.session(m.session);
    to.id(m.asker);
    return to.finish();
}

std::size_t encode(const End& m, MutableBytes out) {
    Writer to{out, Kind::end};
    to.session(m.session);
    to.id(m.asker);
    return to.finish();
}

std::size_t encode(const Report& m, MutableBytes out) {
    Writer to{out, Kind::report};
    to.code(m.channel);
    to.session(m.session);
    to.id(m.plant);
    to.id(m.controller);
    to.code(m.state);
    to.code(m.reason);
    for (const std::uint32_t number :
         {m.counters.samples, m.counters.accepted, m.counters.late, m.counters.repeated,
          m.counters.foreign, m.counters.falls, m.ages.last, m.ages.least, m.ages.smoothed,
          m.ages.greatest, m.ages.jitter}) {
        to.u32(number);
    }
    return to.finish();
}

std::size_t encode(const Invite& m, MutableBytes out) {
    if (m.parameters.size() > most_parameters) return 0;
    Writer to{out, Kind::invite};
    to.session(m.session);
    to.id(m.plant);
    to.code(m.channel);
    to.u16(static_cast<std::uint16_t>(m.law));
    to.u16(m.period_ms);
    to.u16(m.deadline_ms);
    to.octets(m.parameters);
    return to.finish();
}

std::size_t encode(const Answer& m, MutableBytes out) {
    Writer to{out, Kind::answer};
    to.session(m.session);
    to.code(m.reason);
    return to.finish();
}

std::size_t encode(const Sample& m, MutableBytes out) {
    if (m.value.size() > most_value) return 0;
    Writer to{out, Kind::sample};
    to.session(m.session);
    to.u32(m.sequence);
    to.u32(m.tick);
    to.u16(m.age);
    to.octets(m.value);
    return to.finish();
}

std::size_t encode(const Command& m, MutableBytes out) {
    if (m.value.size() > most_value) return 0;
    Writer to{out, Kind::command};
    to.session(m.session);
    to.u32(m.sequence);
    to.u32(m.tick);
    to.octets(m.value);
    return to.finish();
}

std::size_t encode(const Bye& m, MutableBytes out) {
    Writer to{out, Kind::bye};
    to.session(m.session);
    to.code(m.reason);
    return to.finish();
}

}  // namespace romano::control
