#include "overlay/ros2/dds/ros_side.h"

#include <array>
#include <cstring>
#include <span>
#include <string_view>
#include <utility>

#include "overlay/dds/qos.h"
#include "overlay/ros2/dds/ros_codec.h"

namespace romano::ros2 {
namespace {

// ROS 2's default, and what a burst of QoS 1 or 2 may have on its way: more than the uplink's
// window.
constexpr std::int32_t usual_depth = 10;
constexpr std::int32_t reliable_depth = 100;
constexpr std::size_t most_origins = 20'000;

struct ListenerDeleter {
    void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
};
using Listener = std::unique_ptr<dds_listener_t, ListenerDeleter>;

// A bridge's participants must be known when one takes over, and forgotten soon when it is dead.
// All else is as ROS 2 has it.
std::string configuration_of(const RosSettings& settings) {
    std::string interfaces;
    if (!settings.interface.empty()) {
        // The loopback interface multicasts, but does not say so.
        const std::string_view multicast = settings.interface == "lo" ? "true" : "default";
        interfaces = "<Interfaces><NetworkInterface name=\"" + settings.interface +
                     "\" multicast=\"" + std::string(multicast) + "\"/></Interfaces>";
    }
    return "<CycloneDDS><Domain id=\"any\"><General>" + interfaces + "<Transport>" +
           (settings.over_ipv6 ? "udp6" : "udp") +
           "</Transport></General>"
           "<Discovery><SPDPInterval>500ms</SPDPInterval><LeaseDuration>3s</LeaseDuration>"
           "</Discovery>"
           "<Internal><WriterLingerDuration>0s</WriterLingerDuration></Internal>"
           "</Domain></CycloneDDS>";
}

dds::Entity participant_in(std::uint32_t domain) {
    const dds::Qos qos{dds_create_qos()};
    constexpr std::string_view enclave = "enclave=/;";
    dds_qset_userdata(qos.get(), enclave.data(), enclave.size());
    return {dds_create_participant(domain, qos.get(), nullptr),
            "participant in DDS domain " + std::to_string(domain)};
}

dds::Qos qos_of(const MakeEndpoint& endpoint, Release release) {
    const std::int32_t depth = endpoint.reliable ? reliable_depth : usual_depth;
    dds::Qos qos = endpoint.retained && endpoint.writes   ? dds::reliable_for_late_readers(depth, 1)
                   : endpoint.reliable || endpoint.writes ? dds::reliable(depth)
                                                          : dds::best_effort(depth);
    if (endpoint.retained) dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    const dds_data_representation_id_t plain = DDS_DATA_REPRESENTATION_XCDR1;
    dds_qset_data_representation(qos.get(), 1, &plain);
    dds_qset_writer_data_lifecycle(qos.get(), false);
    const std::string user_data = endpoint_user_data(endpoint.type, release);
    dds_qset_userdata(qos.get(), user_data.data(), user_data.size());
    return qos;
}

std::string text_of(const dds_guid_t& guid) {
    constexpr std::string_view hexadecimal = "0123456789abcdef";
    std::string out;
    for (const std::uint8_t octet : guid.v) {
        out += hexadecimal[octet >> 4U];
        out += hexadecimal[octet & 0x0FU];
    }
    return out;
}

bool is_bridges(const dds_qos_t* qos) {
    void* data = nullptr;
    std::size_t size = 0;
    if (qos == nullptr || !dds_qget_userdata(qos, &data, &size) || data == nullptr) return false;
    const bool found = is_of_a_bridge({static_cast<const char*>(data), size});
    dds_free(data);
    return found;
}

RosWriter writer_in(const dds_builtintopic_endpoint_t& endpoint) {
    dds_reliability_kind_t reliability = DDS_RELIABILITY_BEST_EFFORT;
    dds_duration_t ignored = 0;
    dds_durability_kind_t durability = DDS_DURABILITY_VOLATILE;
    dds_qget_reliability(endpoint.qos, &reliability, &ignored);
    dds_qget_durability(endpoint.qos, &durability);
    return {.topic = ros_topic_name(endpoint.topic_name),
            .type = ros_type_name(endpoint.type_name),
            .reliable = reliability == DDS_RELIABILITY_RELIABLE,
            .retained = durability != DDS_DURABILITY_VOLATILE,
            .of_a_bridge = is_bridges(endpoint.qos)};
}

}  // namespace

/// Which readers have samples. DDS's threads write, ours takes.
struct RosSide::Ready {
    std::function<void()> on_ready;
    std::mutex mutex;
    std::set<dds_entity_t> readers;

    void add(dds_entity_t reader) {
        {
            const std::lock_guard lock(mutex);
            readers.insert(reader);
        }
        on_ready();
    }
    std::set<dds_entity_t> take() {
        const std::lock_guard lock(mutex);
        return std::exchange(readers, {});
    }
    Listener listener() {
        Listener out{dds_create_listener(this)};
        dds_lset_data_available(
            out.get(), [](dds_entity_t reader, void* to) { static_cast<Ready*>(to)->add(reader); });
        return out;
    }
};

RosSide::RosSide(const RosSettings& settings, std::function<void()> on_ready)
    : release_(settings.release),
      ready_(std::make_unique<Ready>()),
      domain_(settings.domain, configuration_of(settings)),
      participant_(participant_in(settings.domain)),
      nodes_(participant_, settings.release) {
    ready_->on_ready = std::move(on_ready);
    dds_get_guid(participant_.handle(), &self_);
    publications_ =
        dds::Entity(dds_create_reader(participant_.handle(), DDS_BUILTIN_TOPIC_DCPSPUBLICATION,
                                      nullptr, ready_->listener().get()),
                    "reader of the publishers in DDS domain " + std::to_string(settings.domain));
}

RosSide::~RosSide() = default;

void RosSide::make(const MakeEndpoint& wanted) {
    const dds::Qos qos = qos_of(wanted, release_);
    const std::string name = dds_topic_name(wanted.topic);
    Endpoint made{.type = wanted.type, .topic = {}, .endpoint = {}};
    made.topic =
        dds::Entity(dds_create_topic(participant_.handle(), &descriptor_of(wanted.type, release_),
                                     name.c_str(), nullptr, nullptr),
                    "DDS topic " + name);
    const dds_entity_t topic = made.topic.handle();
    if (wanted.writes) {
        made.endpoint =
            dds::Entity(dds_create_writer(participant_.handle(), topic, qos.get(), nullptr),
                        "writer of DDS topic " + name);
    } else {
        made.endpoint = dds::Entity(
            dds_create_reader(participant_.handle(), topic, qos.get(), ready_->listener().get()),
            "reader of DDS topic " + name);
        topics_of_readers_.emplace(made.endpoint.handle(), wanted.topic);
    }
    nodes_.add(wanted.node, made.endpoint, wanted.writes);
    (wanted.writes ? writers_ : readers_).insert_or_assign(wanted.topic, std::move(made));
}

bool RosSide::write(const std::string& topic, const RosMessage& message) {
    const auto found = writers_.find(topic);
    if (found == writers_.end()) return false;
    return ros2::write(found->second.endpoint.handle(), message, release_) == DDS_RETCODE_OK;
}

void RosSide::close() {
    nodes_.clear();
    topics_of_readers_.clear();
    readers_.clear();
    writers_.clear();
    origins_.clear();
}

std::vector<RosWriter> RosSide::new_writers() {
    std::vector<RosWriter> found;
    std::array<void*, most_at_once> samples{};
    std::array<dds_sample_info_t, most_at_once> infos{};
    for (;;) {
        samples.fill(nullptr);  // DDS lends them
        const dds_return_t taken = dds_take(publications_.handle(), samples.data(), infos.data(),
                                            most_at_once, most_at_once);
        if (taken <= 0) return found;
        for (std::size_t i = 0; i < static_cast<std::size_t>(taken); ++i) {
            const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(samples[i]);
            const std::string guid = text_of(endpoint.key);
            if (infos[i].instance_state != DDS_IST_ALIVE || !infos[i].valid_data) {
                others_.erase(guid);
                continue;
            }
            if (std::memcmp(&endpoint.participant_key, &self_, sizeof self_) == 0) continue;
            RosWriter writer = writer_in(endpoint);
            if (writer.topic.empty() || others_.size() >= most_writers) continue;
            if (others_.emplace(guid, writer).second) found.push_back(std::move(writer));
        }
        dds_return_loan(publications_.handle(), samples.data(), taken);
    }
}

std::vector<RosWriter> RosSide::writers() const {
    std::vector<RosWriter> out;
    for (const auto& [guid, writer] : others_) out.push_back(writer);
    return out;
}

bool RosSide::take(const std::function<void(RosSample)>& on_sample) {
    bool more = false;
    for (const dds_entity_t reader : ready_->take()) take_from(reader, on_sample, more);
    return more;
}

void RosSide::take_from(dds_entity_t reader, const std::function<void(RosSample)>& on_sample,
                        bool& more) {
    const auto topic = topics_of_readers_.find(reader);
    if (topic == topics_of_readers_.end()) return;  // of publishers, or gone
    const RosType type = readers_.at(topic->second).type;
    std::array<void*, most_at_once> samples{};
    std::array<dds_sample_info_t, most_at_once> infos{};
    const dds_return_t taken =
        dds_take(reader, samples.data(), infos.data(), most_at_once, most_at_once);
    if (taken <= 0) return;
    for (std::size_t i = 0; i < static_cast<std::size_t>(taken); ++i) {
        const dds_sample_info_t& info = infos[i];
        if (!info.valid_data) continue;  // a writer came or went
        const Origin& origin = origin_of(reader, info.publication_handle);
        if (origin.of_a_bridge) continue;
        on_sample({topic->second, message_in(samples[i], type, release_),
                   "ros/" + origin.guid + '/' + name_of(info)});
    }
    dds_return_loan(reader, samples.data(), taken);
    if (static_cast<std::size_t>(taken) < most_at_once) return;
    const std::lock_guard lock(ready_->mutex);
    ready_->readers.insert(reader);
    more = true;
}

/// Of a sample among its writer's. Without a time stamp it cannot be known again.
std::string RosSide::name_of(const dds_sample_info_t& info) {
    if (info.source_timestamp > 0) return std::to_string(info.source_timestamp);
    return 'x' + text_of(self_) + '-' + std::to_string(++without_stamp_);
}

const RosSide::Origin& RosSide::origin_of(dds_entity_t reader, dds_instance_handle_t writer) {
    const auto known = origins_.find(writer);
    if (known != origins_.end()) return known->second;
    if (origins_.size() >= most_origins) origins_.clear();
    // A writer that has gone already has no guid any more; its handle here is all that is left.
    Origin origin{.guid = std::to_string(writer), .of_a_bridge = false};
    if (auto* endpoint = dds_get_matched_publication_data(reader, writer)) {
        origin = {.guid = text_of(endpoint->key), .of_a_bridge = is_bridges(endpoint->qos)};
        dds_builtintopic_free_endpoint(endpoint);
    }
    return origins_.emplace(writer, std::move(origin)).first->second;
}

}  // namespace romano::ros2
