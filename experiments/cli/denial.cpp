#include "experiments/cli/denial.h"

namespace romano::experiments {

std::string words_for(mqttsn::ReturnCode code) {
    switch (code) {
        case mqttsn::ReturnCode::accepted:
            return "accepted";
        case mqttsn::ReturnCode::congestion:
            return "congestion: it is full or overloaded; ask again later";
        case mqttsn::ReturnCode::invalid_topic_id:
            return "invalid topic id";
        case mqttsn::ReturnCode::not_supported:
            return "not supported, or not permitted (the broker's trace tells of rights)";
    }
    return "rejected";
}

std::string why_not(const BrokerOptions& broker, std::optional<mqttsn::ReturnCode> denial,
                    bool was_refused) {
    if (!denial) return broker.unreachable(was_refused);
    return "the broker at " + broker.where() + " refused this: " + words_for(*denial);
}

}  // namespace romano::experiments
