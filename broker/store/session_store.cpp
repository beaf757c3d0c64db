#include "broker/store/session_store.h"

#include <sqlite3.h>

#include <algorithm>
#include <optional>
#include <utility>
#include <variant>

#include "broker/store/event_rows.h"
#include "broker/store/schema.h"

namespace romano::store {
namespace {

constexpr std::uint64_t page_octets = 4096;

std::string words_for(const DatabaseError& error) {
    switch (error.code()) {
        case SQLITE_NOTADB:
        case SQLITE_CORRUPT:
            return "is damaged (" + std::string(error.what()) + "); restore it or move it away";
        case SQLITE_BUSY:
        case SQLITE_LOCKED:
            return "is in use by another process; give each broker its own file";
        case SQLITE_FULL:
            return "cannot be written: the disk or the file's own limit is full; make room";
        case SQLITE_IOERR:
            return "cannot be read or written; check the disk and the room on it";
        case SQLITE_READONLY:
        case SQLITE_PERM:
        case SQLITE_CANTOPEN:
            return "cannot be opened for writing; check the path and its permissions";
        default:
            return "cannot be used (" + std::string(error.what()) + "); check the disk";
    }
}

}  // namespace

class SessionStore::Open {
public:
    explicit Open(const StoreOptions& options) : database(options.path) {
        // Until all is known to be well, closing must not change anything.
        database.leave_untouched(true);
        if (database.is_read_only()) throw DatabaseError(SQLITE_READONLY, "read-only");
        database.execute("PRAGMA locking_mode = EXCLUSIVE");
        database.execute("PRAGMA foreign_keys = ON");
        database.execute(
            ("PRAGMA max_page_count = " + std::to_string(options.most_octets / page_octets))
                .c_str());
        if (database.number("PRAGMA user_version") == 0) create_schema(database);
        const std::string check = database.text("PRAGMA quick_check(1)");
        if (check != "ok") throw DatabaseError(SQLITE_CORRUPT, check);
        database.execute("PRAGMA journal_mode = WAL");
        database.execute(options.survives_power_cut ? "PRAGMA synchronous = FULL"
                                                    : "PRAGMA synchronous = NORMAL");
        database.execute("PRAGMA journal_size_limit = 16777216");
        database.execute("BEGIN IMMEDIATE");  // takes the lock for good, and shows that we can
        database.execute("COMMIT");
        update_schema(database);
        database.leave_untouched(false);
    }

    Database database;
    std::optional<EventRows> rows;
};

SessionStore::SessionStore(const StoreOptions& options) {
    if (const std::string why = why_not_ours(options.path); !why.empty()) throw StoreRefusal(why);
    try {
        open_ = std::make_unique<Open>(options);
    } catch (const DatabaseError& error) {
        throw StoreRefusal(words_for(error));
    }
}

SessionStore::~SessionStore() = default;

StoredState SessionStore::load(broker::BrokerId self) {
    try {
        return read_state(open_->database, self);
    } catch (const DatabaseError& error) {
        throw StoreRefusal(words_for(error));
    }
}

std::uint64_t SessionStore::last_incarnation() {
    try {
        return store::last_incarnation(open_->database);
    } catch (const DatabaseError& error) {
        throw StoreRefusal(words_for(error));
    }
}

void SessionStore::begin_log(const broker::LogId& log) {
    open_->rows.emplace(open_->database, log.incarnation);
}

template <typename Write>
bool SessionStore::in_transaction(Write&& write) {
    Database& database = open_->database;
    try {
        database.execute("BEGIN");
        write(*open_->rows);
        database.execute("COMMIT");
        return true;
    } catch (const DatabaseError& error) {
        problem_ = words_for(error);
    }
    try {
        database.execute("ROLLBACK");
    } catch (const DatabaseError&) {
        // SQLite has rolled back by itself already.
    }
    return false;
}

bool SessionStore::keep(const broker::Actions& actions) {
    const auto is_event = [](const broker::Action& action) {
        return std::holds_alternative<broker::Append>(action);
    };
    const auto list = actions.list();
    const auto first = std::ranges::find_if(list, is_event);
    if (first == list.end()) return true;
    return in_transaction([&](EventRows& rows) {
        for (auto at = first; at != list.end(); ++at) {
            if (const auto* append = std::get_if<broker::Append>(&*at)) {
                rows.write(append->seq, *append->event);
            }
        }
    });
}

bool SessionStore::keep_all(const broker::BrokerCore& broker) {
    return in_transaction([&](EventRows& rows) {
        rows.clear();
        for (broker::SessionImage& image : broker.images()) {
            rows.write(0, broker::SessionPut{std::move(image)});
        }
        for (const auto& message : broker.retained()) rows.put_retained(*message);
    });
}

}  // namespace romano::store
