#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "voxelserver/data/sqlite/untrusted_database.hpp"

struct sqlite3_stmt;

namespace terravox::store {

/// A read-only connection to an SQLite file that another program makes and may be writing to, or to
/// an untrusted file, with limits on the cost of statements, so that no content can exhaust the
/// memory or cause an endless loop. For one thread at a time.
class ReadOnlyDatabase {
public:
    /// @param immutable as of sqlite::UntrustedFileOptions
    /// @throws Error
    ReadOnlyDatabase(const std::filesystem::path& file, bool immutable);
    ReadOnlyDatabase(const ReadOnlyDatabase&) = delete;
    ReadOnlyDatabase& operator=(const ReadOnlyDatabase&) = delete;

    /// Reads one value.
    /// @return nullopt when there is no row, or NULL
    /// @throws Error
    [[nodiscard]] std::optional<std::int64_t> number(const char* sql);
    /// Whether it has an ordinary table of that name. A view could be endless.
    [[nodiscard]] bool has_table(const char* name);
    [[nodiscard]] sqlite3* get() const noexcept { return m_database.get(); }
    [[noreturn]] void fail() const;  ///< @throws Error with SQLite's message

private:
    std::string m_attempt;  ///< begins messages
    int m_callbacks_left;  ///< remaining calls of the progress handler, for all statements together
    sqlite::Connection m_database;
};

/// A statement without parameters, and its result rows.
class Rows {
public:
    Rows(ReadOnlyDatabase& database, const char* sql);  ///< @throws Error
    ~Rows();
    Rows(const Rows&) = delete;
    Rows& operator=(const Rows&) = delete;

    /// Advances to the next row.
    /// @return whether there is one
    /// @throws Error
    [[nodiscard]] bool next();

    // Columns of the current row, from 0; nullopt when the value has another type.
    [[nodiscard]] bool is_null(int column) const noexcept;
    [[nodiscard]] std::optional<std::string> text(int column) const;
    [[nodiscard]] std::optional<std::int64_t> integer(int column) const noexcept;
    [[nodiscard]] std::optional<double> number(int column) const noexcept;  ///< finite

private:
    ReadOnlyDatabase& m_database;
    sqlite3_stmt* m_statement = nullptr;
};

}  // namespace terravox::store
