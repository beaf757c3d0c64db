// The folder of a fleet's keys, on the computer of whoever owns the fleet:
//
//     clients.keys               all clients and their keys
//     places.given               how many places brokers were given
//     authority.pem, .key        who signs the certificates (authority.h)
//     revoked.pem                the brokers' certificates that count no more
//     brokers/NAME/              a broker's --keys folder: clients.keys, broker.place, by what
//                                brokers know each other (peer_papers.h), and what the broker
//                                keeps there
//     robots/NAME.key            a robot's own file, to be moved to the robot
//     operators/NAME.key         a person's own file
//     certificates/NAME.pem      a client's, for DTLS
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "romano/keys/authority.h"
#include "romano/keys/client_keys.h"

namespace romano::keys {

inline constexpr const char* table_name = "clients.keys";
inline constexpr const char* record_name = "broker.numbers";
inline constexpr const char* place_name = "broker.place";

/// A broker whose certificate expires stands alone at once: it lasts as long as the robot.
inline constexpr int broker_days = 3650;

struct Names {
    std::vector<std::string> brokers;
    std::vector<std::string> robots;
    std::vector<std::string> operators;
};

class KeyFolder {
public:
    explicit KeyFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// Draws keys for new names, gives each broker that is named a place and what other brokers
    /// know it by, and all of them the new table. All or nothing of what is wrong with names: a
    /// client has one key. Throws KeyError.
    void add(const Names& names);
    /// Takes clients from all tables; their own files stay. Brokers' certificates are revoked, and
    /// their folders go.
    void withdraw(const std::vector<std::string>& clients,
                  const std::vector<std::string>& brokers = {});
    /// A new certificate and permissions for a broker; its earlier certificate still counts.
    void renew(const std::string& broker, int days);

    /// Makes a certificate for a client with a key. `client_id` as of client_ids_of(). Returns the
    /// client's file. Throws KeyError.
    std::filesystem::path certify(const std::string& client_id, int days);

    [[nodiscard]] std::filesystem::path own_file(std::string_view name, Role role) const;
    [[nodiscard]] std::filesystem::path broker_folder(std::string_view name) const;
    [[nodiscard]] std::vector<std::string> brokers() const;
    [[nodiscard]] ClientKeys clients() const;

private:
    void write_tables(const ClientKeys& keys) const;
    void give_place(const std::filesystem::path& broker) const;
    void write_revocations(const Authority& authority,
                           const std::optional<std::string>& revoked) const;

    std::filesystem::path folder_;
};

/// What is wrong with a fleet's folder, a broker's, or one key file: a sentence each.
[[nodiscard]] std::vector<std::string> problems_of(const std::filesystem::path& path);

}  // namespace romano::keys
