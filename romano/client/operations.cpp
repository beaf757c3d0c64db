#include "romano/client/operations.h"

#include <cassert>
#include <cstring>

namespace romano::client {

bool OperationQueue::push(Operation operation, std::string_view name, Bytes data) {
    const std::size_t free = octets_.size() - used_;
    if (free < sizeof(Operation) || free - sizeof(Operation) < name.size() ||
        free - sizeof(Operation) - name.size() < data.size()) {
        return false;
    }
    operation.name_size = static_cast<std::uint16_t>(name.size());
    operation.data_size = static_cast<std::uint32_t>(data.size());
    std::uint8_t* at = octets_.data() + used_;
    std::memcpy(at, &operation, sizeof(Operation));
    at += sizeof(Operation);
    if (!name.empty()) std::memcpy(at, name.data(), name.size());
    at += name.size();
    if (!data.empty()) std::memcpy(at, data.data(), data.size());
    used_ += sizeof(Operation) + name.size() + data.size();
    return true;
}

Operation OperationQueue::front() const {
    assert(!empty());
    Operation operation;
    std::memcpy(&operation, octets_.data(), sizeof(Operation));
    return operation;
}

std::string_view OperationQueue::front_name() const {
    return as_text(Bytes{octets_}.subspan(sizeof(Operation), front().name_size));
}

Bytes OperationQueue::front_data() const {
    const Operation operation = front();
    return Bytes{octets_}.subspan(sizeof(Operation) + operation.name_size, operation.data_size);
}

void OperationQueue::update_front(const Operation& operation) {
    assert(!empty());
    std::memcpy(octets_.data(), &operation, sizeof(Operation));
}

void OperationQueue::pop() {
    const Operation operation = front();
    const std::size_t gone = sizeof(Operation) + operation.name_size + operation.data_size;
    used_ -= gone;
    std::memmove(octets_.data(), octets_.data() + gone, used_);
}

}  // namespace romano::client
