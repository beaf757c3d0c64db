#include "overlay/ros2/dds/node_graph.h"

#include <algorithm>
#include <cstring>
#include <iterator>

#include "overlay/dds/qos.h"
#include "overlay/ros2/dds/humble_types.h"
#include "overlay/ros2/dds/ros_types.h"

namespace romano::ros2 {
namespace {

constexpr const char* graph_topic = "ros_discovery_info";

dds_guid_t guid_of(const dds::Entity& entity) {
    dds_guid_t guid{};
    dds_get_guid(entity.handle(), &guid);
    return guid;
}

dds_topic_descriptor_t graph_of_humble() {
    dds_topic_descriptor_t out = humble_dds__ParticipantEntitiesInfo__desc;
    out.m_typename = rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc.m_typename;
    return out;
}

const dds_topic_descriptor_t& graph_descriptor(Release release) {
    static const dds_topic_descriptor_t humble = graph_of_humble();
    return release == Release::humble ? humble
                                      : rmw_dds_common_msg_dds__ParticipantEntitiesInfo__desc;
}

/// Longer ones end with zeros.
template <typename Gid>
Gid gid_of(const dds_guid_t& guid) {
    Gid out{};
    std::memcpy(out.data, guid.v, sizeof guid.v);
    return out;
}

template <typename Gid>
std::vector<Gid> gids_of(const std::vector<dds_guid_t>& guids) {
    std::vector<Gid> out;
    std::ranges::transform(guids, std::back_inserter(out), gid_of<Gid>);
    return out;
}

template <typename Sequence, typename Item>
void lend(Sequence& out, std::vector<Item>& items) {
    out._length = out._maximum = static_cast<std::uint32_t>(items.size());
    out._buffer = items.data();
}

template <std::size_t size>
void put_name(char (&out)[size], const std::string& text) {
    std::strncpy(out, text.c_str(), size - 1);
}

}  // namespace

NodeGraph::NodeGraph(const dds::Entity& participant, Release release)
    : release_(release),
      participant_(guid_of(participant)),
      topic_(dds_create_topic(participant.handle(), &graph_descriptor(release), graph_topic,
                              nullptr, nullptr),
             "DDS topic " + std::string(graph_topic)) {
    const dds::Qos qos = dds::reliable_for_late_readers(1, 1);
    const dds_data_representation_id_t plain = DDS_DATA_REPRESENTATION_XCDR1;
    dds_qset_data_representation(qos.get(), 1, &plain);
    writer_ =
        dds::Entity(dds_create_writer(participant.handle(), topic_.handle(), qos.get(), nullptr),
                    "writer of DDS topic " + std::string(graph_topic));
}

void NodeGraph::add(const std::string& node, const dds::Entity& endpoint, bool writes) {
    Node& entry = nodes_[node];
    (writes ? entry.writers : entry.readers).push_back(guid_of(endpoint));
    changed_ = true;
}

void NodeGraph::clear() {
    changed_ = changed_ || !nodes_.empty();
    nodes_.clear();
}

void NodeGraph::tell() {
    changed_ = false;
    if (release_ == Release::humble) {
        write<humble_dds__ParticipantEntitiesInfo_, humble_dds__NodeEntitiesInfo_,
              humble_dds__Gid_>();
    } else {
        write<rmw_dds_common_msg_dds__ParticipantEntitiesInfo_,
              rmw_dds_common_msg_dds__NodeEntitiesInfo_, rmw_dds_common_msg_dds__Gid_>();
    }
}

template <typename Info, typename NodeInfo, typename Gid>
void NodeGraph::write() const {
    std::vector<std::vector<Gid>> gids;  // the buffers that `infos` lends
    gids.reserve(2 * nodes_.size());
    std::vector<NodeInfo> infos(nodes_.size());
    auto info = infos.begin();
    for (const auto& [name, node] : nodes_) {
        put_name(info->node_namespace, "/");
        put_name(info->node_name, name);
        lend(info->reader_gid_seq, gids.emplace_back(gids_of<Gid>(node.readers)));
        lend(info->writer_gid_seq, gids.emplace_back(gids_of<Gid>(node.writers)));
        ++info;
    }
    Info out{};
    out.gid = gid_of<Gid>(participant_);
    lend(out.node_entities_info_seq, infos);
    dds_write(writer_.handle(), &out);
}

}  // namespace romano::ros2
