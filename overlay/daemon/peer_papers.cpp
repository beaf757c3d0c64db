#include "overlay/daemon/peer_papers.h"

#include <filesystem>

#include "broker/daemon/refusal.h"
#include "romano/keys/key_error.h"
#include "romano/keys/peer_papers.h"

namespace romano::daemon {
namespace {

std::string first_problem(const std::string& folder) {
    try {
        const auto problems = keys::problems_of_peer_papers(folder);
        return problems.empty() ? "" : problems.front();
    } catch (const keys::KeyError& error) {
        return error.what();
    }
}

}  // namespace

std::optional<dds::Papers> peer_papers(const std::string& folder) {
    const std::string problem = first_problem(folder);
    if (!problem.empty()) {
        throw Refusal("--keys '" + folder + "': " + problem +
                      " (or give --plain-peers, and other brokers are spoken to unprotected)");
    }
    const auto path = [&](const char* name) {
        return (std::filesystem::path(folder) / name).string();
    };
    return dds::Papers{.authority = path(keys::authority_name),
                       .own = path(keys::broker_certificate_name),
                       .governance = path(keys::governance_name),
                       .permissions = path(keys::permissions_name),
                       .revoked = path(keys::revoked_name)};
}

}  // namespace romano::daemon
