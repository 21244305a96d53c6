#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

struct sqlite3;
struct sqlite3_stmt;

namespace terravox::store {

/// An SQLite file that another program makes and may be writing to, or that may be anything:
/// read-only, with limits on what a statement may cost, so that no content can fill the memory or
/// keep us for ever. For one thread at a time.
class ReadOnlyDatabase {
public:
    /// @param immutable nobody writes: no lock is taken, and no file beside it is read or made, so
    /// that a disk without write access will do; false: what is in its write-ahead log counts too
    /// @throws Error
    ReadOnlyDatabase(const std::filesystem::path& file, bool immutable);
    ~ReadOnlyDatabase();
    ReadOnlyDatabase(const ReadOnlyDatabase&) = delete;
    ReadOnlyDatabase& operator=(const ReadOnlyDatabase&) = delete;

    /// One value. @return nullopt when there is no row, or NULL @throws Error
    [[nodiscard]] std::optional<std::int64_t> number(const char* sql);
    /// Whether it has a plain table of that name. A view could be endless.
    [[nodiscard]] bool has_table(const char* name);
    [[nodiscard]] sqlite3* get() const noexcept { return m_database; }
    [[noreturn]] void fail() const;  ///< @throws Error that says what SQLite says

private:
    std::string m_file;
    int m_looks_left;  // of the steps that all statements together may take
    sqlite3* m_database = nullptr;
};

/// A statement without parameters, and its rows.
class Rows {
public:
    Rows(ReadOnlyDatabase& database, const char* sql);  ///< @throws Error
    ~Rows();
    Rows(const Rows&) = delete;
    Rows& operator=(const Rows&) = delete;

    [[nodiscard]] bool next();  ///< @return whether there is another row @throws Error

    // Columns of this row, from 0; nullopt when the value is of another kind.
    [[nodiscard]] bool is_null(int column) const noexcept;
    [[nodiscard]] std::optional<std::string> text(int column) const;
    [[nodiscard]] std::optional<std::int64_t> integer(int column) const noexcept;
    [[nodiscard]] std::optional<double> number(int column) const noexcept;  ///< finite

private:
    ReadOnlyDatabase& m_database;
    sqlite3_stmt* m_statement = nullptr;
};

}  // namespace terravox::store
