#include "broker/store/database.h"

#include <sqlite3.h>

namespace romano::store {

Database::Database(const std::string& path) {
    sqlite3* connection = nullptr;
    const int code =
        sqlite3_open_v2(path.c_str(), &connection,
                        SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX, nullptr);
    connection_.reset(connection);
    if (code != SQLITE_OK) fail(code);
}

void Database::Close::operator()(sqlite3* connection) const {
    sqlite3_close(connection);
}

void Database::fail(int code) const {
    const char* words = connection_ ? sqlite3_errmsg(connection_.get()) : sqlite3_errstr(code);
    throw DatabaseError(code & 0xFF, words);
}

void Database::execute(const char* sql) {
    const int code = sqlite3_exec(connection_.get(), sql, nullptr, nullptr, nullptr);
    if (code != SQLITE_OK) fail(code);
}

std::int64_t Database::number(const char* sql) {
    std::int64_t found = 0;
    Statement(*this, sql).each([&found](const Row& row) { found = row.number(0); });
    return found;
}

std::string Database::text(const char* sql) {
    std::string found;
    Statement(*this, sql).each([&found](const Row& row) { found = row.text(0); });
    return found;
}

std::int64_t Database::last_insert_id() const {
    return sqlite3_last_insert_rowid(connection_.get());
}

bool Database::is_read_only() const {
    return sqlite3_db_readonly(connection_.get(), "main") == 1;
}

void Database::leave_untouched(bool untouched) {
    sqlite3_db_config(connection_.get(), SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, untouched ? 1 : 0,
                      nullptr);
}

bool Row::is_null(int column) const {
    return sqlite3_column_type(statement_, column) == SQLITE_NULL;
}

std::int64_t Row::number(int column) const {
    return sqlite3_column_int64(statement_, column);
}

std::string_view Row::text(int column) const {
    return as_text(octets(column));
}

Bytes Row::octets(int column) const {
    const void* octets = sqlite3_column_blob(statement_, column);
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(statement_, column));
    return {static_cast<const std::uint8_t*>(octets), size};
}

Statement::Statement(Database& database, const char* sql) : database_(database) {
    sqlite3_stmt* statement = nullptr;
    const int code = sqlite3_prepare_v3(database.connection_.get(), sql, -1,
                                        SQLITE_PREPARE_PERSISTENT, &statement, nullptr);
    statement_.reset(statement);
    if (code != SQLITE_OK) database.fail(code);
}

void Statement::Finalize::operator()(sqlite3_stmt* statement) const {
    sqlite3_finalize(statement);
}

void Statement::bind(int at, std::int64_t value) {
    sqlite3_bind_int64(statement_.get(), at, value);
}

// Empty views may have no address, which SQLite would take for NULL.
void Statement::bind(int at, std::string_view value) {
    sqlite3_bind_text64(statement_.get(), at, value.empty() ? "" : value.data(), value.size(),
                        SQLITE_STATIC, SQLITE_UTF8);
}

void Statement::bind(int at, Bytes value) {
    if (value.empty()) {
        sqlite3_bind_zeroblob(statement_.get(), at, 0);
    } else {
        sqlite3_bind_blob64(statement_.get(), at, value.data(), value.size(), SQLITE_STATIC);
    }
}

void Statement::bind(int at, std::nullptr_t) {
    sqlite3_bind_null(statement_.get(), at);
}

bool Statement::step() {
    const int code = sqlite3_step(statement_.get());
    if (code == SQLITE_ROW) return true;
    if (code != SQLITE_DONE) database_.fail(code);
    return false;
}

void Statement::reset() {
    sqlite3_reset(statement_.get());
    sqlite3_clear_bindings(statement_.get());
}

}  // namespace romano::store
