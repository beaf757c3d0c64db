// Writes samples of one sender to one DDS topic, numbered from 1.
#pragma once

#include <cstdint>
#include <string>

#include "broker/core/log_position.h"
#include "overlay/dds/entity.h"
#include "overlay/dds/qos.h"
#include "romano/base/bytes.h"

namespace romano::dds {

class SampleWriter {
public:
    /// Throws DdsError.
    SampleWriter(const Entity& participant, const std::string& topic, const Qos& qos,
                 const broker::LogId& sender);

    /// False when DDS did not take it.
    bool write(Bytes body);

private:
    Entity topic_;
    Entity writer_;
    broker::LogId sender_;
    std::uint64_t last_number_ = 0;
};

}  // namespace romano::dds
