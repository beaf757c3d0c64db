#include "broker/store/schema.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "romano/base/bytes.h"

namespace romano::store {
namespace {

constexpr const char* tables = R"(
CREATE TABLE sessions(
    id INTEGER PRIMARY KEY, client_id TEXT NOT NULL UNIQUE,
    address TEXT NOT NULL, wireless_node_id BLOB NOT NULL, via TEXT NOT NULL,
    state INTEGER NOT NULL CHECK(state BETWEEN 0 AND 4), clean INTEGER NOT NULL,
    keep_alive_s INTEGER NOT NULL, sleep_s INTEGER NOT NULL,
    epoch INTEGER NOT NULL, last_heard INTEGER NOT NULL,
    departed INTEGER NOT NULL DEFAULT 0,
    will_topic TEXT, will_message BLOB, will_qos INTEGER CHECK(will_qos BETWEEN 0 AND 2),
    will_retain INTEGER);
CREATE TABLE subscriptions(
    id INTEGER PRIMARY KEY, session INTEGER NOT NULL REFERENCES sessions ON DELETE CASCADE,
    filter TEXT NOT NULL, type INTEGER NOT NULL CHECK(type BETWEEN 0 AND 2),
    predefined_id INTEGER NOT NULL, granted INTEGER NOT NULL CHECK(granted BETWEEN 0 AND 2),
    UNIQUE(session, filter));
CREATE TABLE topics(
    session INTEGER NOT NULL REFERENCES sessions ON DELETE CASCADE,
    id INTEGER NOT NULL CHECK(id BETWEEN 1 AND 65534), name TEXT NOT NULL, known_to_client INTEGER NOT NULL,
    PRIMARY KEY(session, id)) WITHOUT ROWID;
CREATE TABLE unreleased(
    id INTEGER PRIMARY KEY, session INTEGER NOT NULL REFERENCES sessions ON DELETE CASCADE,
    msg_id INTEGER NOT NULL);
CREATE INDEX unreleased_of_session ON unreleased(session, msg_id);
CREATE TABLE messages(
    id INTEGER PRIMARY KEY, incarnation INTEGER NOT NULL, seq INTEGER NOT NULL,
    topic TEXT NOT NULL, payload BLOB NOT NULL, qos INTEGER NOT NULL CHECK(qos BETWEEN 0 AND 2), retain INTEGER NOT NULL,
    published_at INTEGER NOT NULL, UNIQUE(incarnation, seq));
CREATE TABLE retained(topic TEXT PRIMARY KEY, message INTEGER NOT NULL) WITHOUT ROWID;
CREATE INDEX retained_by_message ON retained(message);
CREATE TABLE deliveries(
    id INTEGER PRIMARY KEY, session INTEGER NOT NULL REFERENCES sessions ON DELETE CASCADE,
    message INTEGER NOT NULL, qos INTEGER NOT NULL CHECK(qos BETWEEN 1 AND 2),
    retain INTEGER NOT NULL, stage INTEGER NOT NULL CHECK(stage BETWEEN 0 AND 2), msg_id INTEGER NOT NULL);
CREATE INDEX deliveries_of_session ON deliveries(session, message);
CREATE INDEX deliveries_of_message ON deliveries(message);
CREATE TRIGGER delivered AFTER DELETE ON deliveries BEGIN
    DELETE FROM messages WHERE id = old.message
        AND NOT EXISTS (SELECT 1 FROM deliveries WHERE message = old.message)
        AND NOT EXISTS (SELECT 1 FROM retained WHERE message = old.message);
END;
CREATE TRIGGER replaced AFTER DELETE ON retained BEGIN
    DELETE FROM messages WHERE id = old.message
        AND NOT EXISTS (SELECT 1 FROM deliveries WHERE message = old.message);
END;
)";

// SQLite's file format, section 1.3: the magic, user version and application id.
constexpr std::string_view magic{"SQLite format 3\0", 16};
constexpr std::size_t user_version_at = 60;
constexpr std::size_t application_id_at = 68;
constexpr std::size_t header_size = 100;

std::uint32_t be32(Bytes octets, std::size_t at) {
    return std::uint32_t{be16(octets, at)} << 16U | be16(octets, at + 2);
}

void set_version(Database& database) {
    database.execute(("PRAGMA user_version = " + std::to_string(schema_version)).c_str());
}

}  // namespace

std::string why_not_ours(const std::string& path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (status.type() == std::filesystem::file_type::not_found) return {};
    if (error) {  // a folder on the way that this user may not enter
        return "cannot be reached (" + error.message() + "); check the path and its permissions";
    }
    if (status.type() != std::filesystem::file_type::regular) {
        return "is no regular file; give the path of a file";
    }
    if (std::filesystem::file_size(path, error) == 0 && !error) return {};
    std::array<std::uint8_t, header_size> header{};
    std::ifstream file(path, std::ios::binary);
    if (!file) return "cannot be read; check its permissions";
    file.read(reinterpret_cast<char*>(header.data()), header.size());
    const bool whole = static_cast<std::size_t>(file.gcount()) == header.size();
    if (!whole || !as_text(header).starts_with(magic) ||
        be32(header, application_id_at) != static_cast<std::uint32_t>(application_id)) {
        return "is no store of romano-broker; give another path";
    }
    const std::uint32_t version = be32(header, user_version_at);
    if (version > static_cast<std::uint32_t>(schema_version)) {
        return "was written by a newer romano-broker (version " + std::to_string(version) +
               " of the store, this one reads up to " + std::to_string(schema_version) +
               "); use that one or give another path";
    }
    return {};
}

void create_schema(Database& database) {
    database.execute("BEGIN IMMEDIATE");
    database.execute(tables);
    database.execute(("PRAGMA application_id = " + std::to_string(application_id)).c_str());
    set_version(database);
    database.execute("COMMIT");
}

void update_schema(Database& database) {
    if (database.number("PRAGMA user_version") == schema_version) return;
    database.execute("BEGIN IMMEDIATE");
    database.execute("ALTER TABLE sessions ADD COLUMN departed INTEGER NOT NULL DEFAULT 0");
    set_version(database);
    database.execute("COMMIT");
}

}  // namespace romano::store
