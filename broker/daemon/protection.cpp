#include "broker/daemon/protection.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

#include "broker/daemon/dtls_metrics.h"
#include "broker/daemon/refusal.h"
#include "broker/net/clock.h"
#include "broker/net/endpoint_text.h"
#include "broker/protection/protected_node.h"
#include "romano/keys/authority.h"
#include "romano/keys/client_keys.h"
#include "romano/keys/key_error.h"
#include "romano/keys/key_folder.h"
#include "romano/keys/private_file.h"
#include "romano/keys/random_octets.h"

namespace romano::daemon {
namespace {

namespace fs = std::filesystem;

// A broker numbers for all its clients: with 100,000 packets a second it writes its record every
// second instead of 24 times.
constexpr std::uint32_t numbers_stored_at_once = 16 * protection::numbers_a_block;

// A full disk is not asked again with each packet, by a thread each time.
constexpr auto stored_again_after = std::chrono::seconds{1};

constexpr std::array<const char*, protection::refusal_kinds> refusal_names = {
    "too_long",       "unstored",       "used_up",   "robot_unheard", "malformed", "unprotected",
    "unknown_scheme", "unknown_sender", "other_run", "replayed",      "bad_tag",   "forwarded"};

Protection::TableLook look_at(const fs::path& table) {
    std::error_code none;
    return {fs::last_write_time(table, none), fs::file_size(table, none)};
}

std::vector<broker::ProtectedClient> clients_of(const keys::ClientKeys& table) {
    std::vector<broker::ProtectedClient> clients;
    for (const auto& [name, owner] : table) {
        for (const std::string& id : keys::client_ids_of(name, owner.role)) {
            clients.push_back({id, keys::key_of(owner, id)});
        }
    }
    return clients;
}

std::vector<rights::KeyOwner> owners_of(const keys::ClientKeys& table) {
    std::vector<rights::KeyOwner> owners;
    for (const auto& [name, owner] : table) {
        owners.push_back(
            {name, owner.role == keys::Role::robot ? rights::Role::robot : rights::Role::person});
    }
    return owners;
}

}  // namespace

std::unique_ptr<Protection> open_protection(const Settings& settings) {
    if (!settings.keys) return nullptr;
    const std::string& folder = *settings.keys;
    try {
        auto protection = std::make_unique<Protection>(folder, settings.limits);
        const auto own =
            std::ranges::find(settings.listen, Endpoint::Packets::dtls, &Endpoint::packets);
        const bool has_own = own != settings.listen.end();
        // In a cluster a peer may have such an address.
        const bool is_served = (has_own || settings.cluster) && protection->serve_dtls();
        if (has_own && !is_served) {
            throw Refusal("--listen '" + net::to_text(*own) +
                          "': needs a place among the brokers "
                          "of the fleet, and --keys '" +
                          folder +
                          "' has none; say `romano keys new "
                          "FLEET --broker NAME` and move the broker.place that it makes there");
        }
        return protection;
    } catch (const keys::KeyError& error) {
        throw Refusal("--keys '" + folder + "': " + error.what());
    }
}

Protection::Protection(fs::path folder, const broker::Limits& limits)
    : folder_(std::move(folder)),
      lock_(folder_ / "broker.lock"),
      record_(keys::read_broker_record(folder_ / keys::record_name)),
      heard_(folder_ / "clients.heard"),
      clients_(record_.identity, record_.bound, limits.stranger_answers_per_second) {
    if (!lock_.try_take(0)) {
        throw keys::KeyError(
            "is in use by another broker; each needs a folder of its own "
            "(`romano keys new DIR --broker NAME`)");
    }
    const fs::path given = folder_ / keys::place_name;
    if (const auto place = keys::read_given_place(given)) record_.place = *place;
    read_table();
    store_bound(0);
    end_storing();
    if (!clients_.reserve().has(clients_.reserve().unused())) {
        throw keys::KeyError(
            "its numbers cannot be stored, or are used up; the broker must be "
            "able to write there");
    }
    std::error_code none;
    fs::remove(given, none);  // it is in the record now
}

bool Protection::serve_dtls() {
    static_assert(keys::most_places == dtls::most_places);
    if (record_.place == 0 || record_.bound >= dtls::most_count) return false;
    protection::Key secret;
    keys::fill_at_random(secret);
    try {
        dtls_.emplace(dtls::Speaker{record_.place, clients_.reserve()}, secret, certificates());
    } catch (const std::runtime_error& error) {
        throw keys::KeyError(error.what());
    }
    dtls_->set_clients(with_keys_);
    return true;
}

/// What `romano keys new` made, if it did.
std::optional<dtls::Certificates> Protection::certificates() const {
    const fs::path own = folder_ / keys::broker_certificate_name;
    const fs::path authority = folder_ / keys::authority_name;
    if (!fs::exists(own) || !fs::exists(authority)) return std::nullopt;
    dtls::Certificates read{keys::read_private_file(own), keys::read_private_file(authority)};
    if (const auto flaw = keys::flaw_of(read.own)) spdlog::warn("{}: {}", own.string(), *flaw);
    return read;
}

void Protection::read_table() {
    const fs::path table = folder_ / keys::table_name;
    const TableLook look = look_at(table);
    const keys::ClientKeys keys = keys::read_table(table);
    read_at_ = look;
    warned_of_.clear();
    owners_ = owners_of(keys);
    with_keys_ = clients_of(keys);
    clients_.set_clients(with_keys_, [this](const auto& sender) { return heard_.of(sender); });
    if (dtls_) dtls_->set_clients(with_keys_);
}

void Protection::admit(Instant now, const Endpoint& via, const Endpoint& from, Bytes datagram,
                       broker::Actions& out, const dtls::Listener::Deliver& deliver) {
    if (broker::is_dtls(via)) {
        if (dtls_) dtls_->take(now, {via, from}, datagram, out, deliver);
        return;
    }
    const Bytes admitted = admit_sealed(now, via, from, datagram, out);
    if (!admitted.empty()) deliver({{via, from}, admitted});
}

Bytes Protection::admit_sealed(Instant now, const Endpoint& via, const Endpoint& from,
                               Bytes datagram, broker::Actions& out) {
    const Bytes admitted = clients_.admit(now, via, from, datagram, out);
    if (const auto heard = clients_.to_store()) {
        if (!heard_.add(*heard)) {
            ++unstored_;
            warn("cannot be written, so protected packets are dropped");
            return {};
        }
        clients_.on_stored();
    }
    return admitted;
}

void Protection::seal(broker::Actions& actions) {
    store_bound(actions.list().size());
    clients_.seal(actions);
    if (dtls_) dtls_->seal(actions);
}

void Protection::on_time(Instant now, broker::Actions& out) {
    if (!dtls_) return;
    dtls_->on_time(now, out);
    const dtls::Handshakes& handshakes = dtls_->handshakes();
    handshake_memory_.on_time(now, handshakes.size(), handshakes.agreed() + handshakes.failed());
}

/// Nothing is sealed beyond what is stored. There is a block ahead of the next one to be stored, so
/// that a disk is seldom waited for.
void Protection::store_bound(std::size_t about_to_seal) {
    protection::Reserve& reserve = clients_.reserve();
    if (storing_.valid()) {
        const bool is_stored =
            storing_.wait_for(std::chrono::seconds{0}) == std::future_status::ready;
        const auto last = reserve.unused() + static_cast<std::uint32_t>(about_to_seal);
        if (!is_stored && reserve.has(last)) return;
        end_storing();
    }
    const auto bound = reserve.to_store(numbers_stored_at_once);
    if (!bound || net::now() < stored_again_at_) return;
    record_.bound = *bound;
    storing_ = std::async(std::launch::async,
                          [file = folder_ / keys::record_name, record = record_]() -> std::string {
                              try {
                                  keys::write_broker_record(file, record);
                                  return {};
                              } catch (const keys::KeyError& error) {
                                  return error.what();
                              }
                          });
}

void Protection::end_storing() {
    const std::string error = storing_.get();
    if (error.empty()) {
        clients_.reserve().on_stored(record_.bound);
    } else {
        stored_again_at_ = net::now() + stored_again_after;
        warn(error);
    }
}

bool Protection::look() {
    const TableLook now = look_at(folder_ / keys::table_name);
    const bool is_written = std::exchange(looked_at_, now) != now;  // perhaps it still is
    if (is_written || now == read_at_) return false;
    try {
        read_table();
        spdlog::info("{} clients have keys now", clients_.size());
        return true;
    } catch (const keys::KeyError& error) {
        warn(std::string{error.what()} + "; the keys of before stay");
        return false;
    }
}

void Protection::leave() {
    try {
        heard_.add_all(clients_.heard());
    } catch (const keys::KeyError& error) {
        warn(error.what());
    }
}

void Protection::warn(const std::string& what) {
    if (std::exchange(warned_of_, what) != what) spdlog::warn("{}: {}", folder_.string(), what);
}

void Protection::add_metrics(metrics::Page& page) const {
    const broker::ProtectionCounters counters = clients_.counters();
    page.gauge("romano_protected_clients", "Clients with a key for protected packets.",
               static_cast<double>(clients_.size()));
    const auto packets = [&page](const char* direction, std::uint64_t value) {
        page.counter("romano_protected_packets_total",
                     "Protected packets that were taken, or made.", value,
                     {{"direction", direction}});
    };
    packets("in", counters.opened);
    packets("out", counters.sealed);
    const auto refused = [&page](const char* reason, std::uint64_t value) {
        page.counter("romano_protection_refusals_total",
                     "Datagrams that protection dropped, by reason.", value, {{"reason", reason}});
    };
    for (std::size_t kind = 0; kind < refusal_names.size(); ++kind) {
        refused(refusal_names[kind], counters.refused[kind]);
    }
    refused("foreign_client_id", counters.foreign_client_id);
    refused("needs_protection", counters.needs_protection);
    refused("stranger_rate", counters.stranger_rate);
    refused("keyless", counters.keyless);
    refused("not_stored", unstored_);
    if (dtls_) add_dtls(page, *dtls_);
}

}  // namespace romano::daemon
