// Who may speak protected packets, and by which key: the lines of key files and of brokers' tables.
//
//     robot abcd1234 00112233445566778899aabbccddeeff          a client with that client id
//     operator anna ffeeddccbbaa99887766554433221100           a person: clients anna, anna/1 ...
//     anna/15
//
// A client's own file has one such line, and behind the key the bound of the numbers that it has
// used (romano/protection/reserve.h): key and bound are one record, so that neither is ever without
// the other. Empty lines, and lines that begin with '#', say nothing.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "romano/protection/keys.h"

namespace romano::keys {

enum class Role : std::uint8_t { robot, person };

/// "robot" or "operator".
[[nodiscard]] std::string_view name_of(Role role);

struct ClientKey {
    Role role = Role::robot;
    protection::Key key{};

    friend bool operator==(const ClientKey&, const ClientKey&) = default;
};

/// By name.
using ClientKeys = std::map<std::string, ClientKey, std::less<>>;

/// So many programs of a person can be connected at a time.
inline constexpr unsigned sessions_of_a_person = 16;

/// Of a robot one, with its name; of a person `sessions_of_a_person`.
[[nodiscard]] std::vector<std::string> client_ids_of(std::string_view name, Role role);
/// The key of one of them.
[[nodiscard]] protection::RobotKey key_of(const ClientKey& owner, std::string_view client_id);

/// 1 to 20 letters, digits, '-' and '_': with a session's number no longer than the 23 octets that
/// MQTT-SN 1.2 section 5.3.1 gives a client id.
[[nodiscard]] bool is_name(std::string_view text);

/// Throws KeyError, with the line. A name stands there once.
[[nodiscard]] ClientKeys read_table(const std::filesystem::path& file);
void write_table(const std::filesystem::path& file, const ClientKeys& keys);

struct OwnKey {
    std::string name;
    ClientKey client;
    std::uint32_t bound = 0;
};
/// A client's own file. Throws KeyError.
[[nodiscard]] OwnKey read_own_key(const std::filesystem::path& file);
void write_own_key(const std::filesystem::path& file, const OwnKey& own);

[[nodiscard]] std::string hex(const protection::Key& key);

}  // namespace romano::keys
