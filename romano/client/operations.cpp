#include "romano/client/operations.h"

#include <cassert>
#include <cstring>

namespace romano::client {

bool OperationQueue::push(Operation operation, std::string_view name, Bytes data) {
    const std::size_t size = sizeof(Operation) + name.size() + data.size();
    if (size > octets_.size() - used_) return false;
    operation.name_size = static_cast<std::uint16_t>(name.size());
    operation.data_size = static_cast<std::uint16_t>(data.size());
    std::uint8_t* at = octets_.data() + used_;
    std::memcpy(at, &operation, sizeof(Operation));
    at += sizeof(Operation);
    if (!name.empty()) std::memcpy(at, name.data(), name.size());
    at += name.size();
    if (!data.empty()) std::memcpy(at, data.data(), data.size());
    if (used_ == 0) load_front();
    used_ += size;
    return true;
}

std::string_view OperationQueue::front_name() const {
    return as_text(Bytes{octets_}.subspan(sizeof(Operation), front_.name_size));
}

Bytes OperationQueue::front_data() const {
    return Bytes{octets_}.subspan(sizeof(Operation) + front_.name_size, front_.data_size);
}

void OperationQueue::pop() {
    assert(!empty());
    const std::size_t gone = sizeof(Operation) + front_.name_size + front_.data_size;
    used_ -= gone;
    std::memmove(octets_.data(), octets_.data() + gone, used_);
    if (used_ != 0) load_front();
}

void OperationQueue::load_front() {
    std::memcpy(&front_, octets_.data(), sizeof(Operation));
}

}  // namespace romano::client
