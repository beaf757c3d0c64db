// A world whose robots speak DTLS by the shipped record layer: what their handshakes agreed on, and
// all records that were ever sealed in it. No number may be used twice under one key, and no broker
// may take what no robot said, or one record twice.
//
// A handshake is one question and one answer here, each lost and repeated as it comes: what its
// cookie, its randoms and its Finished are for, the world knows.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "broker/dtls/dtls_clients.h"
#include "romano/base/bytes.h"
#include "romano/dtls/record/record_cipher.h"

namespace romano::sim {

class DtlsRecords {
public:
    using Octets = std::vector<std::uint8_t>;
    enum class Way : std::uint8_t { to_broker, to_robot };

    /// Nobody else can ask so.
    void on_asked(std::uint64_t question) { asked_.insert(question); }
    [[nodiscard]] bool was_asked(std::uint64_t question) const { return asked_.contains(question); }
    /// What a question led to, for when it comes again, and so that no other answer counts.
    [[nodiscard]] const Octets* answered(std::uint64_t question) const;
    void on_answered(std::uint64_t question, dtls::AssociationId id, const dtls::RecordKeys& keys,
                     const Octets& answer);
    /// Of robot and question; nobody else knows them.
    [[nodiscard]] static dtls::RecordKeys keys_of(std::string_view robot, std::uint64_t question);

    // --- as records leave
    void on_robot_sealed(dtls::AssociationId id, Bytes record, Bytes message);
    void on_broker_sealed(Bytes record);
    /// `broker` is one life of one.
    void on_taken(const std::string& broker, Bytes record, Bytes message);

    [[nodiscard]] std::size_t count() const { return used_.size(); }
    [[nodiscard]] std::size_t taken() const { return taken_.size(); }
    [[nodiscard]] std::uint64_t moved() const { return moved_; }
    void on_moved() { ++moved_; }
    /// What must not be, a sentence each.
    [[nodiscard]] const std::vector<std::string>& wrongs() const { return wrongs_; }

private:
    void note(dtls::AssociationId id, Way way, std::uint64_t number);

    struct Agreed {
        dtls::AssociationId id;
        dtls::RecordKeys keys;
    };

    std::set<std::uint64_t> asked_;
    std::map<std::uint64_t, Octets> answers_;
    std::vector<Agreed> agreed_;
    std::set<std::tuple<dtls::AssociationId, Way, std::uint64_t>> used_;
    std::map<Octets, Octets> said_;  // record and message
    std::set<std::pair<std::string, Octets>> taken_;
    std::uint64_t moved_ = 0;  // robots, to other addresses
    dtls::RecordCipher cipher_;
    std::vector<std::string> wrongs_;
};

}  // namespace romano::sim
