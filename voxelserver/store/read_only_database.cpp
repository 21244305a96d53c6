#include "voxelserver/store/read_only_database.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <cmath>

#include "common/util/error.hpp"

namespace terravox::store {
namespace {

constexpr int kBusyTimeout_ms = 10'000;         // while another process recovers or checkpoints
constexpr int kLongestValue_bytes = 1'000'000;  // and row: the longest are lists of addresses
constexpr int kStepsPerLook = 1'000'000, kMaxLooks = 2'000;

/// Escapes the characters of a name that have a meaning in SQLite's URIs.
std::string uri_of(const std::filesystem::path& file, bool immutable) {
    std::string out = "file:";
    constexpr char kHex[] = "0123456789ABCDEF";
    for (const unsigned char c : std::filesystem::absolute(file).string()) {
        if (c == '%' || c == '?' || c == '#') {
            out += '%';
            out += kHex[c >> 4];
            out += kHex[c & 15];
        } else
            out += static_cast<char>(c);
    }
    return out + (immutable ? "?immutable=1" : "");
}

std::string one_line(std::string text) {
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c > '~'; }, ' ');
    return text.substr(0, 300);
}

int count_down(void* looks) noexcept {
    return --*static_cast<int*>(looks) < 0 ? 1 : 0;
}

}  // namespace

ReadOnlyDatabase::ReadOnlyDatabase(const std::filesystem::path& file, bool immutable)
    : m_file(file.string()), m_looks_left(kMaxLooks) {
    const int flags =
        SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_PRIVATECACHE;
    if (sqlite3_open_v2(uri_of(file, immutable).c_str(), &m_database, flags, nullptr) !=
        SQLITE_OK) {
        const std::string why =
            m_database != nullptr ? sqlite3_errmsg(m_database) : "out of memory";
        sqlite3_close(m_database);
        throw util::Error("read the store's list " + m_file + ": " + one_line(why));
    }
    sqlite3_busy_timeout(m_database, kBusyTimeout_ms);
    sqlite3_limit(m_database, SQLITE_LIMIT_LENGTH, kLongestValue_bytes);
    sqlite3_db_config(m_database, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(m_database, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    sqlite3_progress_handler(m_database, kStepsPerLook, count_down, &m_looks_left);
}

ReadOnlyDatabase::~ReadOnlyDatabase() {
    sqlite3_close(m_database);
}

void ReadOnlyDatabase::fail() const {
    const int code = sqlite3_errcode(m_database) & 0xff;
    const char* hint = code == SQLITE_NOTADB || code == SQLITE_CORRUPT
                           ? "; allowed: a sound fishnet.gpkg that the grabber made"
                           : "";
    throw util::Error("read the store's list " + m_file + ": " +
                      one_line(sqlite3_errmsg(m_database)) + hint);
}

std::optional<std::int64_t> ReadOnlyDatabase::number(const char* sql) {
    Rows rows(*this, sql);
    return rows.next() ? rows.integer(0) : std::nullopt;
}

bool ReadOnlyDatabase::has_table(const char* name) {
    Rows rows(*this, "SELECT name, sql FROM sqlite_master WHERE type = 'table'");
    while (rows.next())
        if (rows.text(0) == name)
            return !rows.text(1).value_or("").starts_with("CREATE VIRTUAL");
    return false;
}

Rows::Rows(ReadOnlyDatabase& database, const char* sql) : m_database(database) {
    if (sqlite3_prepare_v2(database.get(), sql, -1, &m_statement, nullptr) != SQLITE_OK)
        database.fail();
}

Rows::~Rows() {
    sqlite3_finalize(m_statement);
}

bool Rows::next() {
    const int code = sqlite3_step(m_statement);
    if (code != SQLITE_ROW && code != SQLITE_DONE)
        m_database.fail();
    return code == SQLITE_ROW;
}

bool Rows::is_null(int column) const noexcept {
    return sqlite3_column_type(m_statement, column) == SQLITE_NULL;
}

std::optional<std::string> Rows::text(int column) const {
    if (sqlite3_column_type(m_statement, column) != SQLITE_TEXT)
        return std::nullopt;
    const auto* first = reinterpret_cast<const char*>(sqlite3_column_text(m_statement, column));
    if (first == nullptr)
        return std::nullopt;
    return std::string(first, static_cast<std::size_t>(sqlite3_column_bytes(m_statement, column)));
}

std::optional<std::int64_t> Rows::integer(int column) const noexcept {
    if (sqlite3_column_type(m_statement, column) != SQLITE_INTEGER)
        return std::nullopt;
    return sqlite3_column_int64(m_statement, column);
}

std::optional<double> Rows::number(int column) const noexcept {
    const int type = sqlite3_column_type(m_statement, column);
    if (type != SQLITE_INTEGER && type != SQLITE_FLOAT)
        return std::nullopt;
    const double value = sqlite3_column_double(m_statement, column);
    return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

}  // namespace terravox::store
