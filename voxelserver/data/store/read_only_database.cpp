#include "voxelserver/data/store/read_only_database.hpp"

#include <sqlite3.h>

#include <cmath>

#include "common/util/error.hpp"

namespace terravox::store {
namespace {

constexpr int kMaxValue_bytes = 1'000'000;  // and row: the longest are lists of addresses
constexpr int kStepsPerCallback = 1'000'000;
constexpr int kMaxCallbacks = 2'000;

int count_down(void* callbacks_left) noexcept {
    return --*static_cast<int*>(callbacks_left) < 0 ? 1 : 0;
}

}  // namespace

ReadOnlyDatabase::ReadOnlyDatabase(const std::filesystem::path& file, bool immutable)
    : m_attempt("read the store's list " + file.string()),
      m_callbacks_left(kMaxCallbacks),
      m_database(sqlite::open_untrusted(
          file, {.immutable = immutable, .max_value_bytes = kMaxValue_bytes}, m_attempt)) {
    sqlite3_progress_handler(m_database.get(), kStepsPerCallback, count_down, &m_callbacks_left);
}

void ReadOnlyDatabase::fail() const {
    const int code = sqlite3_errcode(m_database.get()) & 0xff;
    const char* hint = code == SQLITE_NOTADB || code == SQLITE_CORRUPT
                           ? "; allowed: a sound fishnet.gpkg that the grabber made"
                           : "";
    throw util::Error(m_attempt + ": " + sqlite::last_error(m_database.get()) + hint);
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
