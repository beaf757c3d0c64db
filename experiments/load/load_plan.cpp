#include "experiments/load/load_plan.h"

#include <algorithm>

namespace romano::experiments {
namespace {

/// Member `member` of `members` who take `topics` in turn, or share them.
std::vector<std::uint32_t> topics_of(std::uint32_t member, std::uint32_t members,
                                     std::uint32_t topics) {
    if (topics <= members) return {member % topics};
    std::vector<std::uint32_t> found;
    for (std::uint32_t topic = member; topic < topics; topic += members) found.push_back(topic);
    return found;
}

}  // namespace

std::uint32_t LoadPlan::receivers_of(std::uint32_t topic) const {
    if (subscribers == 0) return 0;
    if (topics >= subscribers) return 1;
    return subscribers / topics + (topic < subscribers % topics ? 1 : 0);
}

std::vector<std::uint32_t> LoadPlan::published_by(std::uint32_t client) const {
    if (client >= publishers) return {};
    return topics_of(client, publishers, topics);
}

std::vector<std::uint32_t> LoadPlan::heard_by(std::uint32_t client) const {
    if (client < publishers) return {};
    return topics_of(client - publishers, subscribers, topics);
}

std::uint32_t LoadPlan::most_topics_of_a_client() const {
    const std::uint32_t fewest = subscribers == 0 ? publishers : std::min(publishers, subscribers);
    return (topics + fewest - 1) / fewest;
}

}  // namespace romano::experiments
