// A type of Fast DDS whose samples are ready octets: CDR with its encapsulation header, as they go
// over the wire.
#pragma once

#include <algorithm>
#include <cstdint>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <functional>
#include <string>
#include <vector>

namespace romano::bench::ros {

class AsOctets final : public eprosima::fastdds::dds::TopicDataType {
public:
    using Octets = std::vector<std::uint8_t>;  // what writers write and readers take
    using Payload = eprosima::fastrtps::rtps::SerializedPayload_t;

    /// Room for `octets` is made at first; with PREALLOCATED_WITH_REALLOC it grows.
    AsOctets(const std::string& name, std::uint32_t octets) {
        setName(name.c_str());
        m_typeSize = octets;
        m_isGetKeyDefined = false;
    }
    bool serialize(void* data, Payload* payload) override {
        const auto& octets = *static_cast<Octets*>(data);
        if (octets.size() > payload->max_size) return false;
        std::ranges::copy(octets, payload->data);
        payload->length = static_cast<std::uint32_t>(octets.size());
        return true;
    }
    bool deserialize(Payload* payload, void* data) override {
        static_cast<Octets*>(data)->assign(payload->data, payload->data + payload->length);
        return true;
    }
    std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
        return [data] { return static_cast<std::uint32_t>(static_cast<Octets*>(data)->size()); };
    }
    void* createData() override { return new Octets; }
    void deleteData(void* data) override { delete static_cast<Octets*>(data); }
    bool getKey(void*, eprosima::fastrtps::rtps::InstanceHandle_t*, bool) override { return false; }
};

}  // namespace romano::bench::ros
