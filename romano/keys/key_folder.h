// The folder of a fleet's keys, on the computer of whoever owns the fleet:
//
//     clients.keys               all clients and their keys
//     places.given               how many places brokers were given
//     brokers/NAME/              a broker's --keys folder: clients.keys, broker.place, and what the
//                                broker keeps there
//     robots/NAME.key            a robot's own file, to be moved to the robot
//     operators/NAME.key         a person's own file
//
// With certificates of DTLS (authority.h) there are also authority.pem, authority.key, in each
// broker's folder authority.pem and broker.pem, and certificates/NAME.pem.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "romano/keys/client_keys.h"

namespace romano::keys {

inline constexpr const char* table_name = "clients.keys";
inline constexpr const char* record_name = "broker.numbers";
inline constexpr const char* place_name = "broker.place";

struct Names {
    std::vector<std::string> brokers;
    std::vector<std::string> robots;
    std::vector<std::string> operators;
};

class KeyFolder {
public:
    explicit KeyFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

    /// Draws keys for new names, gives each broker that is named a place, and all of them the new
    /// table. All or nothing of what is wrong with names: a client has one key. Throws KeyError.
    void add(const Names& names);
    /// Takes clients from all tables; their own files stay.
    void withdraw(const std::vector<std::string>& clients);

    /// Makes a certificate for a client with a key, and for each broker that has none; the fleet's
    /// authority, too, when there is none. `client_id` as of client_ids_of(). Returns the
    /// client's file. Throws KeyError.
    std::filesystem::path certify(const std::string& client_id, int days);

    [[nodiscard]] std::filesystem::path own_file(std::string_view name, Role role) const;
    [[nodiscard]] std::filesystem::path broker_folder(std::string_view name) const;
    [[nodiscard]] std::vector<std::string> brokers() const;
    [[nodiscard]] ClientKeys clients() const;

private:
    void write_tables(const ClientKeys& keys) const;
    void give_place(const std::filesystem::path& broker) const;

    std::filesystem::path folder_;
};

/// What is wrong with a fleet's folder, a broker's, or one key file: a sentence each.
[[nodiscard]] std::vector<std::string> problems_of(const std::filesystem::path& path);

}  // namespace romano::keys
