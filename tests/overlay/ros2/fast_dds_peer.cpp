// A peer in ROS 2's domain on Fast DDS, which nobody here wrote, with ROS 2's names and QoS:
//
//     fast_dds_peer DOMAIN humble|iron [sub TYPE TOPIC QOS]... [pub TYPE TOPIC QOS COUNT MS
//     TEXT]...
//
// QOS is reliable, best-effort or latched. TEXT gives the fields in order; % in it is the number of
// the message. Publishers begin once somebody subscribes. It prints a line for each thing that it
// sees, until it is killed:
//
//     ready | matched TOPIC | subscribed TOPIC
//     at TOPIC MILLISECONDS | bytes TOPIC same|HEX | got TOPIC FIELDS    (three for each message)
//     writer TOPIC TYPE USER-DATA
//     nodes none | nodes NAME/SUBSCRIPTIONS/PUBLISHERS...

#include <fastcdr/Cdr.h>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/DataWriterListener.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <functional>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <type_traits>

#include "bench/ros/node/as_octets.h"
#include "tests/overlay/ros2/ros_fields.h"

namespace {

using namespace eprosima::fastdds::dds;
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
namespace peer = romano::ros2::peer;
using romano::bench::ros::AsOctets;
using Octets = AsOctets::Octets;

constexpr std::size_t most_octets = 1U << 20U;

void say(const std::string& line) {
    static std::mutex mutex;
    const std::lock_guard lock(mutex);
    std::cout << line << std::endl;
}

long long milliseconds() {
    return std::chrono::duration_cast<std::chrono::milliseconds>(
               std::chrono::steady_clock::now().time_since_epoch())
        .count();
}

template <class T>
constexpr bool is_vector = false;
template <class T>
constexpr bool is_vector<std::vector<T>> = true;
template <class T>
constexpr bool is_plain = std::is_arithmetic_v<T> || std::is_same_v<T, std::string>;

struct Encoder {
    Cdr& cdr;
    template <class T>
    void operator()(T& value) {
        if constexpr (is_plain<T>) {
            cdr << value;
        } else if constexpr (is_vector<T>) {
            cdr << static_cast<std::uint32_t>(value.size());
            for (auto& item : value) (*this)(item);
        } else {
            value.visit(*this);
        }
    }
};

struct Decoder {
    Cdr& cdr;
    template <class T>
    void operator()(T& value) {
        if constexpr (is_plain<T>) {
            cdr >> value;
        } else if constexpr (is_vector<T>) {
            std::uint32_t size = 0;
            cdr >> size;
            value.resize(std::min<std::size_t>(size, most_octets));
            for (auto& item : value) (*this)(item);
        } else {
            value.visit(*this);
        }
    }
};

struct TextOut {
    std::ostringstream text;
    template <class T>
    void operator()(T& value) {
        if constexpr (sizeof(T) == 1 && std::is_arithmetic_v<T>) {
            text << ' ' << static_cast<int>(value);
        } else if constexpr (is_plain<T>) {
            text << ' ' << value;
        } else if constexpr (is_vector<T>) {
            text << " [" << value.size();
            for (auto& item : value) (*this)(item);
            text << " ]";
        } else {
            value.visit(*this);
        }
    }
};

/// Reads what stands there; the rest stays as it is.
struct TextIn {
    std::istringstream text;
    template <class T>
    void operator()(T& value) {
        if constexpr (sizeof(T) == 1 && std::is_arithmetic_v<T>) {
            int number = 0;
            if (text >> number) value = static_cast<T>(number);
        } else if constexpr (is_plain<T>) {
            T read{};
            if (text >> read) value = read;
        } else if constexpr (is_vector<T>) {
            std::size_t size = 0;
            text >> size;
            value.resize(text ? size : 0);
            for (auto& item : value) (*this)(item);
        } else {
            value.visit(*this);
        }
    }
};

template <class Message>
Octets encoded(Message& message) {
    std::vector<char> room(most_octets);
    FastBuffer buffer(room.data(), room.size());
    Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
    cdr.serialize_encapsulation();
    Encoder{cdr}(message);
    return {room.begin(),
            room.begin() + static_cast<std::ptrdiff_t>(cdr.getSerializedDataLength())};
}

template <class Message>
Message decoded(Octets octets) {
    FastBuffer buffer(reinterpret_cast<char*>(octets.data()), octets.size());
    Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, Cdr::DDS_CDR);
    cdr.read_encapsulation();
    Message message;
    Decoder{cdr}(message);
    return message;
}

/// The octets behind the encapsulation header, without what only fills up to four.
Octets body_of(const Octets& octets) {
    const std::size_t padding = octets.size() > 3 ? octets[3] & 3U : 0;
    return {octets.begin() + 4, octets.end() - static_cast<std::ptrdiff_t>(padding)};
}

std::string hex_of(const Octets& octets) {
    std::ostringstream out;
    for (const std::uint8_t octet : octets) {
        out << "0123456789abcdef"[octet >> 4U] << "0123456789abcdef"[octet & 15U];
    }
    return out.str();
}

struct Kind {
    std::string dds_name;
    std::function<Octets(const std::string& text)> make;
    std::function<void(const std::string& topic, const Octets&)> tell;
};

template <class Message>
Kind kind(const std::string& dds_name) {
    return {dds_name,
            [](const std::string& text) {
                Message message;
                TextIn{std::istringstream(text)}(message);
                return encoded(message);
            },
            [](const std::string& topic, const Octets& octets) {
                Message message = decoded<Message>(octets);
                const bool same = body_of(encoded(message)) == body_of(octets);
                say("at " + topic + ' ' + std::to_string(milliseconds()));
                say("bytes " + topic + ' ' + (same ? "same" : hex_of(octets)));
                TextOut out;
                out(message);
                say("got " + topic + out.text.str());
            }};
}

template <std::size_t gid>
Kind graph() {
    return {"rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_",
            {},
            [](const std::string&, const Octets& octets) {
                auto info = decoded<peer::ParticipantEntitiesInfo<gid>>(octets);
                std::vector<std::string> nodes;
                for (const auto& node : info.node_entities_info_seq) {
                    nodes.push_back(' ' + node.node_namespace + node.node_name + '/' +
                                    std::to_string(node.reader_gid_seq.size()) + '/' +
                                    std::to_string(node.writer_gid_seq.size()));
                }
                std::ranges::sort(nodes);
                std::string line = nodes.empty() ? "nodes none" : "nodes";
                for (const std::string& node : nodes) line += node;
                say(line);
            }};
}

std::map<std::string, Kind> kinds_of(bool humble) {
    return {
        {"Twist", kind<peer::Twist>("geometry_msgs::msg::dds_::Twist_")},
        {"Odometry", kind<peer::Odometry>("nav_msgs::msg::dds_::Odometry_")},
        {"BatteryState", kind<peer::BatteryState>("sensor_msgs::msg::dds_::BatteryState_")},
        {"Range", humble ? kind<peer::HumbleRange>("sensor_msgs::msg::dds_::Range_")
                         : kind<peer::Range>("sensor_msgs::msg::dds_::Range_")},
        {"String", kind<peer::String>("std_msgs::msg::dds_::String_")},
        {"UInt8MultiArray", kind<peer::UInt8MultiArray>("std_msgs::msg::dds_::UInt8MultiArray_")},
        {"graph", humble ? graph<24>() : graph<16>()},
    };
}

class Discovery : public DomainParticipantListener {
public:
    void on_publisher_discovery(DomainParticipant*,
                                eprosima::fastrtps::rtps::WriterDiscoveryInfo&& info) override {
        if (info.status != info.DISCOVERED_WRITER) return;
        const auto& user_data = info.info.m_qos.m_userData.data_vec();
        say("writer " + info.info.topicName().to_string() + ' ' + info.info.typeName().to_string() +
            ' ' + std::string(user_data.begin(), user_data.end()));
    }
};

class Reading : public DataReaderListener {
public:
    Reading(std::string topic, const Kind& what) : topic_(std::move(topic)), kind_(what) {}
    void on_data_available(DataReader* reader) override {
        Octets octets;
        SampleInfo info;
        while (reader->take_next_sample(&octets, &info) == ReturnCode_t::RETCODE_OK) {
            if (info.valid_data) kind_.tell(topic_, octets);
        }
    }
    void on_subscription_matched(DataReader*, const SubscriptionMatchedStatus& status) override {
        if (status.current_count_change > 0) say("subscribed " + topic_);
    }

private:
    std::string topic_;
    const Kind& kind_;
};

class Writing : public DataWriterListener {
public:
    explicit Writing(std::string topic) : topic_(std::move(topic)) {}
    void on_publication_matched(DataWriter*, const PublicationMatchedStatus& status) override {
        matched = status.current_count;
        if (status.current_count_change > 0) say("matched " + topic_);
    }
    std::atomic<int> matched{0};

private:
    std::string topic_;
};

template <class Qos>
Qos with(Qos qos, const std::string& name) {
    qos.reliability().kind =
        name == "best-effort" ? BEST_EFFORT_RELIABILITY_QOS : RELIABLE_RELIABILITY_QOS;
    qos.durability().kind =
        name == "latched" ? TRANSIENT_LOCAL_DURABILITY_QOS : VOLATILE_DURABILITY_QOS;
    qos.history().kind = KEEP_LAST_HISTORY_QOS;
    qos.history().depth = name == "latched" ? 1 : 100;
    qos.endpoint().history_memory_policy =
        eprosima::fastrtps::rtps::PREALLOCATED_WITH_REALLOC_MEMORY_MODE;
    return qos;
}

class Peer {
public:
    Peer(unsigned domain, bool humble) : kinds_(kinds_of(humble)) {
        DomainParticipantQos qos;
        const std::string enclave = "enclave=/;";
        qos.user_data().setValue({enclave.begin(), enclave.end()});
        qos.transport().use_builtin_transports = false;
        auto loopback = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
        loopback->interfaceWhiteList.emplace_back("127.0.0.1");
        qos.transport().user_transports.push_back(loopback);
        auto* factory = DomainParticipantFactory::get_instance();
        participant_ = factory->create_participant(domain, qos, &discovery_, StatusMask::none());
        if (participant_ == nullptr) throw std::runtime_error("no participant");
        publisher_ = participant_->create_publisher(PUBLISHER_QOS_DEFAULT);
        subscriber_ = participant_->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
        subscribe("graph", "ros_discovery_info", "ros_discovery_info", "latched");
    }
    ~Peer() {
        participant_->delete_contained_entities();
        DomainParticipantFactory::get_instance()->delete_participant(participant_);
    }
    Peer(const Peer&) = delete;
    Peer& operator=(const Peer&) = delete;

    void subscribe(const std::string& type, const std::string& name, const std::string& dds_name,
                   const std::string& qos) {
        readings_.push_back(std::make_unique<Reading>(name, kinds_.at(type)));
        auto* reader = subscriber_->create_datareader(
            topic(type, dds_name), with(DATAREADER_QOS_DEFAULT, qos), readings_.back().get());
        if (reader == nullptr) throw std::runtime_error("no reader of " + name);
    }
    void publish(const std::string& type, const std::string& name, const std::string& qos,
                 int count, int every_ms, const std::string& text) {
        writings_.push_back(std::make_unique<Writing>(name));
        auto* writer = publisher_->create_datawriter(
            topic(type, "rt" + name), with(DATAWRITER_QOS_DEFAULT, qos), writings_.back().get());
        if (writer == nullptr) throw std::runtime_error("no writer of " + name);
        publishing_.emplace_back([=, this, &writing = *writings_.back()] {
            while (writing.matched == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
            for (int n = 1; n <= count; ++n) {
                std::string numbered = text;
                if (const auto at = text.find('%'); at != std::string::npos) {
                    numbered.replace(at, 1, std::to_string(n));
                }
                Octets octets = kinds_.at(type).make(numbered);
                writer->write(&octets);
                std::this_thread::sleep_for(std::chrono::milliseconds(every_ms));
            }
        });
    }
    void finish() {
        for (auto& thread : publishing_) thread.join();
    }

private:
    Topic* topic(const std::string& type, const std::string& name) {
        const std::string& dds_type = kinds_.at(type).dds_name;
        if (participant_->find_type(dds_type).empty()) {
            participant_->register_type(TypeSupport(new AsOctets(dds_type, most_octets)));
        }
        Topic*& made = topics_[name];
        if (made == nullptr) made = participant_->create_topic(name, dds_type, TOPIC_QOS_DEFAULT);
        return made;
    }

    std::map<std::string, Kind> kinds_;
    Discovery discovery_;
    std::vector<std::unique_ptr<Reading>> readings_;
    std::vector<std::unique_ptr<Writing>> writings_;
    std::vector<std::thread> publishing_;
    std::map<std::string, Topic*> topics_;
    DomainParticipant* participant_ = nullptr;
    Publisher* publisher_ = nullptr;
    Subscriber* subscriber_ = nullptr;
};

}  // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    Peer ros(static_cast<unsigned>(std::stoul(words.at(0))), words.at(1) == "humble");
    for (std::size_t i = 2; i < words.size();) {
        if (words.at(i) == "sub") {
            ros.subscribe(words.at(i + 1), words.at(i + 2), "rt" + words.at(i + 2),
                          words.at(i + 3));
            i += 4;
        } else {
            ros.publish(words.at(i + 1), words.at(i + 2), words.at(i + 3),
                        std::stoi(words.at(i + 4)), std::stoi(words.at(i + 5)), words.at(i + 6));
            i += 7;
        }
    }
    say("ready");
    ros.finish();
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}
