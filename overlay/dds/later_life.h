// A later life of this broker that others have heard. They drop what an earlier one says, so a
// broker whose machine's clock went back between two starts would be heard by nobody.
//
// Whoever heard it writes to its inbox, whose name says which life it is of; and DDS tells which
// topics are written.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <memory>

#include "broker/core/log_position.h"
#include "overlay/dds/entity.h"
#include "overlay/dds/wakeup.h"

namespace romano::dds {

class LaterLife {
public:
    /// Called with the later one's incarnation.
    using OnKnown = std::function<void(std::uint64_t incarnation)>;

    /// Throws DdsError.
    LaterLife(boost::asio::io_context& io, const Entity& participant, const broker::LogId& self,
              OnKnown on_known);

private:
    void look() const;

    broker::LogId self_;
    OnKnown on_known_;
    std::shared_ptr<Wakeup> wakeup_;
    Entity writers_;  // goes first: its listener uses the rest
};

}  // namespace romano::dds
