#include "voxelserver/serve/boxes/sqlite.hpp"

#include <filesystem>
#include <system_error>

namespace terravox::boxes {
namespace {

constexpr int kBusyTimeout_ms = 5000;  // while another process writes

[[noreturn]] void fail(sqlite3* database, const char* attempt) {
    const int code = database != nullptr ? sqlite3_extended_errcode(database) : SQLITE_NOMEM;
    const int plain = code & 0xff;
    const auto category =
        plain == SQLITE_CORRUPT || plain == SQLITE_NOTADB ? SqliteError::Category::kDamaged
        : plain == SQLITE_BUSY || plain == SQLITE_LOCKED  ? SqliteError::Category::kBusy
                                                          : SqliteError::Category::kOther;
    const char* file = database != nullptr ? sqlite3_db_filename(database, "main") : nullptr;
    throw SqliteError(std::string(attempt) + " " + (file != nullptr ? file : "") + ": " +
                          (database != nullptr ? sqlite3_errmsg(database) : "out of memory"),
                      category);
}

}  // namespace

Statement::Statement(sqlite3* database, std::string_view sql) : m_database(database) {
    if (sqlite3_prepare_v3(database, sql.data(), static_cast<int>(sql.size()),
                           SQLITE_PREPARE_PERSISTENT, &m_statement, nullptr) != SQLITE_OK)
        fail(database, "read the cache file");
}

Statement& Statement::bind(int at, std::int64_t value) {
    sqlite3_bind_int64(m_statement, at + 1, value);
    return *this;
}

Statement& Statement::bind_bytes(int at, const std::string* bytes) {
    if (bytes == nullptr)
        sqlite3_bind_null(m_statement, at + 1);
    else
        sqlite3_bind_blob64(m_statement, at + 1, bytes->data(), bytes->size(), SQLITE_STATIC);
    return *this;
}

bool Statement::step() {
    const int code = sqlite3_step(m_statement);
    if (code == SQLITE_ROW)
        return true;
    if (code != SQLITE_DONE)
        fail(m_database, "use the cache file");
    return false;
}

void Statement::reset() noexcept {
    sqlite3_reset(m_statement);
    sqlite3_clear_bindings(m_statement);
}

std::shared_ptr<const std::string> Statement::bytes(int column) const {
    if (sqlite3_column_type(m_statement, column) == SQLITE_NULL)
        return nullptr;
    const auto* first = static_cast<const char*>(sqlite3_column_blob(m_statement, column));
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(m_statement, column));
    return std::make_shared<const std::string>(first == nullptr ? "" : first,
                                               first == nullptr ? 0 : size);
}

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
        fail(m_database, "use the cache file");
}

std::int64_t Database::number(const char* sql) {
    Statement statement(m_database, sql);
    return statement.step() ? statement.integer(0) : 0;
}

}  // namespace terravox::boxes
