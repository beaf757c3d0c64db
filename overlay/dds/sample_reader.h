// Takes samples from one DDS topic, into storage that it keeps.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "broker/core/log_position.h"
#include "overlay/dds/entity.h"
#include "overlay/dds/qos.h"
#include "overlay/dds/wakeup.h"
#include "romano/base/bytes.h"

namespace romano::dds {

/// A sample while on_sample runs.
struct SampleView {
    broker::LogId from;
    std::uint64_t number = 0;
    Bytes body;
};

class SampleReader {
public:
    static constexpr std::size_t most_at_once = 2;

    /// Rings `wakeup` when samples arrive. Throws DdsError.
    SampleReader(const Entity& participant, const std::string& topic, const Qos& qos,
                 std::shared_ptr<Wakeup> wakeup);
    ~SampleReader();
    SampleReader(const SampleReader&) = delete;
    SampleReader& operator=(const SampleReader&) = delete;

    /// Takes up to most_at_once samples; returns how many were there.
    std::size_t take(const std::function<void(const SampleView&)>& on_sample);

private:
    struct Storage;

    std::shared_ptr<Wakeup> wakeup_;
    std::unique_ptr<Storage> storage_;
    Entity topic_;
    Entity reader_;  // goes first: its listener uses the rest
};

}  // namespace romano::dds
