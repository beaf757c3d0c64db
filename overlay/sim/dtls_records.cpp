#include "overlay/sim/dtls_records.h"

#include <algorithm>
#include <array>

#include "romano/protection/keys.h"

namespace romano::sim {

const DtlsRecords::Octets* DtlsRecords::answered(std::uint64_t question) const {
    const auto found = answers_.find(question);
    return found == answers_.end() ? nullptr : &found->second;
}

void DtlsRecords::on_answered(std::uint64_t question, dtls::AssociationId id,
                              const dtls::RecordKeys& keys, const Octets& answer) {
    answers_.emplace(question, answer);
    agreed_.push_back({id, keys});
}

dtls::RecordKeys DtlsRecords::keys_of(std::string_view robot, std::uint64_t question) {
    Octets whose(8);
    dtls::put_be64(whose, 0, question);
    whose.insert(whose.end(), robot.begin(), robot.end());
    dtls::RecordKeys keys;
    const protection::Key world{0x51};
    protection::Key drawn;
    protection::hkdf_sha256(world, {}, "simulated handshake, client ", whose, drawn);
    std::copy_n(drawn.begin(), keys.client.key.size(), keys.client.key.begin());
    protection::hkdf_sha256(world, {}, "simulated handshake, server ", whose, drawn);
    std::copy_n(drawn.begin(), keys.server.key.size(), keys.server.key.begin());
    return keys;
}

void DtlsRecords::note(dtls::AssociationId id, Way way, std::uint64_t number) {
    if (used_.emplace(id, way, number).second) return;
    wrongs_.push_back("number " + std::to_string(number) + " was used twice under one key");
}

void DtlsRecords::on_robot_sealed(dtls::AssociationId id, Bytes record, Bytes message) {
    note(id, Way::to_broker, dtls::first_record(record, 8)->number);
    said_.emplace(Octets(record.begin(), record.end()), Octets(message.begin(), message.end()));
}

void DtlsRecords::on_broker_sealed(Bytes record) {
    const auto parsed = dtls::first_record(record);
    if (!parsed || parsed->epoch == 0) return;  // a handshake's answer, or discovery
    Octets out(record.size());
    // The newest is the likeliest.
    const auto under = std::find_if(agreed_.rbegin(), agreed_.rend(), [&](const Agreed& each) {
        return cipher_.open(each.keys.suite, each.keys.server, *parsed, out).has_value();
    });
    if (under == agreed_.rend()) {
        wrongs_.emplace_back("a broker's record is under nobody's key");
    } else {
        note(under->id, Way::to_robot, parsed->number);
    }
}

void DtlsRecords::on_taken(const std::string& broker, Bytes record, Bytes message) {
    const Octets octets(record.begin(), record.end());
    const auto found = said_.find(octets);
    if (found == said_.end() || !std::ranges::equal(found->second, message)) {
        wrongs_.push_back(broker + " took a record that no robot sealed");
    }
    if (!taken_.emplace(broker, octets).second) wrongs_.push_back(broker + " took a record twice");
}

}  // namespace romano::sim
