#include "overlay/dds/sample_writer.h"

#include "overlay/dds/sample.h"

namespace romano::dds {

SampleWriter::SampleWriter(const Entity& participant, const std::string& topic, const Qos& qos,
                           const broker::LogId& sender)
    : topic_(dds_create_topic(participant.handle(), &romano_wire_Sample_desc, topic.c_str(),
                              nullptr, nullptr),
             "DDS topic " + topic),
      writer_(dds_create_writer(participant.handle(), topic_.handle(), qos.get(), nullptr),
              "writer of DDS topic " + topic),
      sender_(sender) {}

bool SampleWriter::write(Bytes body) {
    romano_wire_Sample sample{};
    sample.broker = static_cast<std::uint64_t>(sender_.broker);
    sample.incarnation = sender_.incarnation;
    sample.number = ++last_number_;
    sample.body._length = static_cast<std::uint32_t>(body.size());
    sample.body._maximum = sample.body._length;
    sample.body._buffer = const_cast<std::uint8_t*>(body.data());  // read only, copied by DDS
    return dds_write(writer_.handle(), &sample) == DDS_RETCODE_OK;
}

}  // namespace romano::dds
