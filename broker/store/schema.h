// The file's tables and its marks: whose file it is (SQLite's application id) and of which version
// (user version). README.md describes the tables.
#pragma once

#include <string>

#include "broker/store/database.h"

namespace romano::store {

inline constexpr int application_id = 0x524F4D41;  // "ROMA"
inline constexpr int schema_version = 2;

/// Why a file cannot be used, as the end of a sentence; empty when it can, or when there is none
/// yet. Reads the file's first octets only: SQLite never sees a file that is not ours.
[[nodiscard]] std::string why_not_ours(const std::string& path);

/// Makes the tables in an empty file.
void create_schema(Database& database);
/// Brings the tables of an older version up to this one.
void update_schema(Database& database);

}  // namespace romano::store
