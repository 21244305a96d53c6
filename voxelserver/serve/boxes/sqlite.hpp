#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "common/util/error.hpp"
#include "voxelserver/data/sqlite/statement.hpp"

namespace terravox::boxes {

/// An error reported by SQLite.
class SqliteError : public util::Error {
public:
    enum class Category {
        kOther,
        kDamaged,  ///< not a database, or a corrupt one
        kBusy,     ///< locked by another process
    };
    SqliteError(const std::string& message, Category category)
        : util::Error(message), m_category(category) {}
    [[nodiscard]] Category category() const noexcept { return m_category; }

private:
    Category m_category;
};

using sqlite::Statement;
using sqlite::StatementReset;

/// A connection, for use by one thread at a time.
class Database {
public:
    /// Opens the file, and creates it when it does not exist.
    /// @throws SqliteError
    explicit Database(const std::string& file);
    ~Database() { sqlite3_close(m_database); }
    Database(const Database&) = delete;
    Database& operator=(const Database&) = delete;

    /// Executes one or more statements without parameters.
    /// @throws SqliteError
    void run(const char* sql);
    [[nodiscard]] Statement prepare(std::string_view sql);  ///< @throws SqliteError, as its steps
    [[nodiscard]] std::int64_t number(const char* sql);     ///< The first column of the first row.
    [[nodiscard]] sqlite3* get() const noexcept { return m_database; }

private:
    sqlite3* m_database = nullptr;
};

}  // namespace terravox::boxes
