// SQLite with C++'s manners: a connection that closes itself, statements that are prepared once,
// errors as exceptions. Nothing here knows what is stored.
#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

#include "romano/base/bytes.h"

struct sqlite3;
struct sqlite3_stmt;

namespace romano::store {

/// What SQLite refused, in its words.
class DatabaseError : public std::runtime_error {
public:
    DatabaseError(int code, const std::string& what) : std::runtime_error(what), code_(code) {}
    /// SQLite's primary result code.
    [[nodiscard]] int code() const { return code_; }

private:
    int code_;
};

class Database {
public:
    /// Opens or creates the file.
    explicit Database(const std::string& path);

    void execute(const char* sql);
    [[nodiscard]] std::int64_t number(const char* sql);  // the only value of a query
    [[nodiscard]] std::string text(const char* sql);
    [[nodiscard]] std::int64_t last_insert_id() const;
    [[nodiscard]] bool is_read_only() const;
    /// On: closing leaves file and write-ahead log exactly as they are.
    void leave_untouched(bool untouched);

private:
    friend class Statement;
    struct Close {
        void operator()(sqlite3* connection) const;
    };
    [[noreturn]] void fail(int code) const;

    std::unique_ptr<sqlite3, Close> connection_;
};

/// One row of a query; views live until the next row.
class Row {
public:
    explicit Row(sqlite3_stmt* statement) : statement_(statement) {}
    [[nodiscard]] bool is_null(int column) const;
    [[nodiscard]] std::int64_t number(int column) const;
    [[nodiscard]] std::string_view text(int column) const;
    [[nodiscard]] Bytes octets(int column) const;

private:
    sqlite3_stmt* statement_;
};

class Statement {
public:
    Statement(Database& database, const char* sql);

    /// Binds ?1, ?2, ... and runs to the end.
    template <typename... Values>
    void run(const Values&... values) {
        const Running running(*this, values...);
        while (step()) {
        }
    }

    /// Calls visit(Row) for each row.
    template <typename Visitor, typename... Values>
    void each(Visitor&& visit, const Values&... values) {
        const Running running(*this, values...);
        while (step()) visit(Row{statement_.get()});
    }

private:
    /// Bound values are views: they must be gone when the call ends, however it ends.
    struct Running {
        template <typename... Values>
        explicit Running(Statement& of, const Values&... values) : statement(of) {
            int at = 0;
            (statement.bind(++at, values), ...);
        }
        ~Running() { statement.reset(); }
        Running(const Running&) = delete;
        Running& operator=(const Running&) = delete;
        Statement& statement;
    };
    struct Finalize {
        void operator()(sqlite3_stmt* statement) const;
    };

    void bind(int at, std::int64_t value);
    void bind(int at, std::string_view value);
    void bind(int at, Bytes value);
    void bind(int at, std::nullptr_t);
    bool step();  // false: no further row
    void reset();

    Database& database_;
    std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

}  // namespace romano::store
