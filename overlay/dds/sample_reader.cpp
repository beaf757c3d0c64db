#include "overlay/dds/sample_reader.h"

#include "overlay/dds/listener.h"
#include "overlay/dds/sample.h"

namespace romano::dds {
// DDS writes samples here again and again and grows their bodies as needed.
struct SampleReader::Storage {
    std::array<romano_wire_Sample, most_at_once> samples{};
    std::array<void*, most_at_once> pointers{};
    std::array<dds_sample_info_t, most_at_once> infos{};

    Storage() {
        for (std::size_t i = 0; i < most_at_once; ++i) pointers[i] = &samples[i];
    }
    ~Storage() {
        for (auto& sample : samples) {
            dds_sample_free(&sample, &romano_wire_Sample_desc, DDS_FREE_CONTENTS);
        }
    }
    Storage(const Storage&) = delete;
    Storage& operator=(const Storage&) = delete;
};

// The listener is given at creation: one that is set later misses what has arrived.
SampleReader::SampleReader(const Entity& participant, const std::string& topic, const Qos& qos,
                           std::shared_ptr<Wakeup> wakeup)
    : wakeup_(std::move(wakeup)),
      storage_(std::make_unique<Storage>()),
      topic_(dds_create_topic(participant.handle(), &romano_wire_Sample_desc, topic.c_str(),
                              nullptr, nullptr),
             "DDS topic " + topic),
      reader_(dds_create_reader(participant.handle(), topic_.handle(), qos.get(),
                                ringing(*wakeup_).get()),
              "reader of DDS topic " + topic) {}

SampleReader::~SampleReader() = default;

std::size_t SampleReader::take(const std::function<void(const SampleView&)>& on_sample) {
    const dds_return_t taken = dds_take(reader_.handle(), storage_->pointers.data(),
                                        storage_->infos.data(), most_at_once, most_at_once);
    if (taken <= 0) return 0;
    const auto count = static_cast<std::size_t>(taken);
    for (std::size_t i = 0; i < count; ++i) {
        if (!storage_->infos[i].valid_data) continue;  // a writer came or went
        const romano_wire_Sample& sample = storage_->samples[i];
        on_sample({.from = {broker::BrokerId{sample.broker}, sample.incarnation},
                   .number = sample.number,
                   .body = {sample.body._buffer, sample.body._length}});
    }
    return count;
}

}  // namespace romano::dds
