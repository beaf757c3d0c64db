#include "tests/romano/client/sequence_chart.h"

#include <algorithm>
#include <sstream>

#include "romano/base/random.h"

namespace romano::client {

using namespace mqttsn;

namespace {

int number(auto value) {
    return static_cast<int>(value);
}

struct Telling {
    std::ostream& to;

    void operator()(const Connected&) const { to << "connected"; }
    void operator()(const Refused& e) const { to << "refused " << number(e.return_code); }
    void operator()(const Lost&) const { to << "lost"; }
    void operator()(const Disconnected& e) const {
        to << (e.by_broker ? "disconnected by broker" : "disconnected");
    }
    void operator()(const Asleep&) const { to << "asleep"; }
    void operator()(const Registered& e) const {
        to << "registered " << number(e.operation) << " id " << number(e.topic_id);
    }
    void operator()(const Subscribed& e) const {
        to << "subscribed " << number(e.operation) << " id " << number(e.topic_id) << " qos "
           << number(e.granted);
    }
    void operator()(const Unsubscribed& e) const { to << "unsubscribed " << number(e.operation); }
    void operator()(const Published& e) const { to << "published " << number(e.operation); }
    void operator()(const WillUpdated& e) const { to << "will updated " << number(e.operation); }
    void operator()(const Failed& e) const {
        to << "failed " << number(e.operation) << " code " << number(e.return_code);
    }
    void operator()(const Congested&) const { to << "congested"; }
    void operator()(const Received& e) const {
        to << "received ";
        if (e.topic.type == TopicIdType::predefined) {
            to << "predefined " << number(e.topic.id);
        } else {
            to << e.topic.name;
        }
        to << " " << as_text(e.data) << " qos " << number(e.qos) << (e.retain ? " retain" : "")
           << (e.dup ? " dup" : "");
    }
};

std::uint64_t seed_whose_first_msg_id_is_1() {
    std::uint64_t seed = 0;
    while ((Random{seed}.next() & 0xFFFFU) != 0) ++seed;
    return seed;
}

}  // namespace

std::string shown(Bytes datagram) {
    std::ostringstream text;
    if (const auto frame = decode_frame(datagram)) text << name_of(frame->type);
    text << std::hex;
    for (const std::uint8_t octet : datagram) text << " " << number(octet);
    return text.str();
}

std::string shown(const Event& event) {
    std::ostringstream text;
    std::visit(Telling{text}, event);
    return text.str();
}

SequenceChart::SequenceChart(const Timing& timing)
    : client_(timing, [] {
          static const std::uint64_t seed = seed_whose_first_msg_id_is_1();
          return seed;
      }()) {}

SequenceChart::~SequenceChart() {
    is_silent();
}

void SequenceChart::connect(const ConnectOptions& options) {
    call([&](auto& client, Instant now, Output& out) { client.connect(now, options, out); });
    sent_.pop_front();
    gets(Connack{ReturnCode::accepted});
    tells("connected");
}

void SequenceChart::subscribe(const TopicRef& topic, TopicId id, Qos granted) {
    call([&](auto& client, Instant now, Output& out) {
        ASSERT_TRUE(client.subscribe(now, topic, granted, out));
    });
    ASSERT_FALSE(sent_.empty());
    const auto request = decode(sent_.front());
    const MsgId msg_id = std::get<Subscribe>(*request).msg_id;
    sent_.pop_front();
    gets(Suback{granted, id, msg_id, ReturnCode::accepted});
    ASSERT_FALSE(told_.empty());
    told_.pop_front();
}

void SequenceChart::register_name(std::string_view name, TopicId id) {
    call([&](auto& client, Instant now, Output& out) {
        ASSERT_TRUE(client.register_name(now, name, out));
    });
    ASSERT_FALSE(sent_.empty());
    const auto request = decode(sent_.front());
    const MsgId msg_id = std::get<Register>(*request).msg_id;
    sent_.pop_front();
    gets(Regack{id, msg_id, ReturnCode::accepted});
    ASSERT_FALSE(told_.empty());
    told_.pop_front();
}

void SequenceChart::publish(const TopicRef& topic, std::string_view data, Qos qos, bool retain) {
    call([&](auto& client, Instant now, Output& out) {
        ASSERT_TRUE(client.publish(now, topic, as_octets(data), {qos, retain}, out));
    });
}

void SequenceChart::sends(const Message& message) {
    const std::string expected = shown(octets_of(message));
    ASSERT_FALSE(sent_.empty()) << "expected " << expected;
    EXPECT_EQ(shown(sent_.front()), expected);
    sent_.pop_front();
}

void SequenceChart::gets(const Message& message) {
    gets_octets(octets_of(message));
}

void SequenceChart::gets_octets(Bytes datagram) {
    client_.on_datagram(now_, datagram, out_);
    take_output();
}

void SequenceChart::after(Duration time) {
    const Instant end = now_ + time;
    for (int steps = 0; client_.next_wakeup() <= end; ++steps) {
        ASSERT_LT(steps, 10'000) << "the client wants to be woken for ever";
        now_ = std::max(now_, client_.next_wakeup());
        client_.on_tick(now_, out_);
        take_output();
    }
    now_ = end;
}

void SequenceChart::tells(std::string_view event) {
    ASSERT_FALSE(told_.empty()) << "expected " << event;
    EXPECT_EQ(told_.front(), event);
    told_.pop_front();
}

void SequenceChart::is_silent() {
    for (const Octets& datagram : sent_) ADD_FAILURE() << "sent " << shown(datagram);
    for (const std::string& event : told_) ADD_FAILURE() << "told " << event;
    sent_.clear();
    told_.clear();
}

void SequenceChart::take_output() {
    for (const Bytes datagram : out_.datagrams()) {
        sent_.emplace_back(datagram.begin(), datagram.end());
    }
    for (const Event& event : out_.events()) told_.push_back(shown(event));
}

}  // namespace romano::client
