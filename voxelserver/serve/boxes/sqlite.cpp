#include "voxelserver/serve/boxes/sqlite.hpp"

#include <filesystem>
#include <system_error>

namespace terravox::boxes {
namespace {

constexpr int kBusyTimeout_ms = 5000;  // while another process writes

[[noreturn]] void fail(sqlite3* database) {
    const int code = database != nullptr ? sqlite3_extended_errcode(database) : SQLITE_NOMEM;
    const int plain = code & 0xff;
    const auto category =
        plain == SQLITE_CORRUPT || plain == SQLITE_NOTADB ? SqliteError::Category::kDamaged
        : plain == SQLITE_BUSY || plain == SQLITE_LOCKED  ? SqliteError::Category::kBusy
                                                          : SqliteError::Category::kOther;
    const char* file = database != nullptr ? sqlite3_db_filename(database, "main") : nullptr;
    throw SqliteError(std::string("use the cache file ") + (file != nullptr ? file : "") + ": " +
                          (database != nullptr ? sqlite3_errmsg(database) : "out of memory"),
                      category);
}

}  // namespace

Database::Database(const std::string& file) {
    // Others may have put a link where the file belongs, to a database of this user. The flag wants
    // a name in which nothing is one, so those before the last are resolved.
    const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX |
                      SQLITE_OPEN_PRIVATECACHE | SQLITE_OPEN_NOFOLLOW;
    const std::filesystem::path path = std::filesystem::absolute(file);
    std::error_code failed;
    const auto folder = std::filesystem::canonical(path.parent_path(), failed);
    const std::string name = failed ? file : (folder / path.filename()).string();
    if (sqlite3_open_v2(name.c_str(), &m_database, flags, nullptr) != SQLITE_OK) {
        const std::string why =
            m_database != nullptr ? sqlite3_errmsg(m_database) : "out of memory";
        sqlite3_close(m_database);
        throw SqliteError("open the cache file " + file + ": " + why,
                          SqliteError::Category::kOther);
    }
    sqlite3_busy_timeout(m_database, kBusyTimeout_ms);
}

void Database::run(const char* sql) {
    if (sqlite3_exec(m_database, sql, nullptr, nullptr, nullptr) != SQLITE_OK)
        fail(m_database);
}

Statement Database::prepare(std::string_view sql) {
    return Statement(m_database, sql, [this] { fail(m_database); });
}

std::int64_t Database::number(const char* sql) {
    Statement statement = prepare(sql);
    return statement.step() ? statement.to_integer(0) : 0;
}

}  // namespace terravox::boxes
