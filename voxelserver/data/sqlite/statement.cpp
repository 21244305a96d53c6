#include "voxelserver/data/sqlite/statement.hpp"

#include <sqlite3.h>

#include <cmath>
#include <utility>

namespace terravox::sqlite {

Statement::Statement(sqlite3* database, std::string_view sql, Fail fail) : m_fail(std::move(fail)) {
    if (sqlite3_prepare_v3(database, sql.data(), static_cast<int>(sql.size()),
                           SQLITE_PREPARE_PERSISTENT, &m_statement, nullptr) != SQLITE_OK)
        m_fail();
}

Statement::Statement(Statement&& other) noexcept
    : m_fail(std::move(other.m_fail)), m_statement(std::exchange(other.m_statement, nullptr)) {}

Statement::~Statement() {
    sqlite3_finalize(m_statement);
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
    if (code != SQLITE_ROW && code != SQLITE_DONE)
        m_fail();
    return code == SQLITE_ROW;
}

void Statement::run() {
    while (step()) {
    }
    reset();
}

void Statement::reset() noexcept {
    sqlite3_reset(m_statement);
    sqlite3_clear_bindings(m_statement);
}

bool Statement::is_null(int column) const noexcept {
    return sqlite3_column_type(m_statement, column) == SQLITE_NULL;
}

std::optional<std::int64_t> Statement::integer(int column) const noexcept {
    if (sqlite3_column_type(m_statement, column) != SQLITE_INTEGER)
        return std::nullopt;
    return to_integer(column);
}

std::optional<double> Statement::number(int column) const noexcept {
    const int type = sqlite3_column_type(m_statement, column);
    if (type != SQLITE_INTEGER && type != SQLITE_FLOAT)
        return std::nullopt;
    const double value = sqlite3_column_double(m_statement, column);
    return std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::optional<std::string> Statement::text(int column) const {
    if (sqlite3_column_type(m_statement, column) != SQLITE_TEXT)
        return std::nullopt;
    const auto* first = reinterpret_cast<const char*>(sqlite3_column_text(m_statement, column));
    if (first == nullptr)
        return std::nullopt;
    return std::string(first, static_cast<std::size_t>(sqlite3_column_bytes(m_statement, column)));
}

std::optional<std::string_view> Statement::bytes(int column) const noexcept {
    if (sqlite3_column_type(m_statement, column) != SQLITE_BLOB)
        return std::nullopt;
    const auto* first = static_cast<const char*>(sqlite3_column_blob(m_statement, column));
    const auto size = static_cast<std::size_t>(sqlite3_column_bytes(m_statement, column));
    return first == nullptr ? std::string_view("") : std::string_view(first, size);
}

std::int64_t Statement::to_integer(int column) const noexcept {
    return sqlite3_column_int64(m_statement, column);
}

}  // namespace terravox::sqlite
