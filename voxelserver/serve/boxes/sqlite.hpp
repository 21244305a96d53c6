#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "common/util/error.hpp"

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

/// A prepared statement. Usage: bind, call step() until it returns false while reading columns,
/// then reset() before the next use. Not thread-safe.
class Statement {
public:
    Statement(sqlite3* database, std::string_view sql);  ///< @throws SqliteError
    ~Statement() { sqlite3_finalize(m_statement); }
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    /// @param at of the parameter, from 0: that of ?1
    Statement& bind(int at, std::int64_t value);
    /// @param bytes nullptr: NULL; else must stay alive until reset()
    Statement& bind_bytes(int at, const std::string* bytes);
    /// Executes the next step.
    /// @return whether there is a row
    /// @throws SqliteError
    bool step();
    void run() {  ///< runs to completion and resets
        while (step()) {
        }
        reset();
    }
    void reset() noexcept;

    /// @param column from 0
    [[nodiscard]] std::int64_t integer(int column) const {
        return sqlite3_column_int64(m_statement, column);
    }
    [[nodiscard]] std::int32_t int32(int column) const {
        return sqlite3_column_int(m_statement, column);
    }
    [[nodiscard]] std::shared_ptr<const std::string> bytes(int column) const;  ///< nullptr for NULL

private:
    sqlite3* m_database;
    sqlite3_stmt* m_statement = nullptr;
};

/// Resets a statement at the end of a scope, also on exceptions.
class StatementReset {
public:
    explicit StatementReset(Statement& statement) : m_statement(statement) {}
    ~StatementReset() { m_statement.reset(); }
    StatementReset(const StatementReset&) = delete;
    StatementReset& operator=(const StatementReset&) = delete;

private:
    Statement& m_statement;
};

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
    [[nodiscard]] std::int64_t number(const char* sql);  ///< The first column of the first row.
    [[nodiscard]] sqlite3* get() const noexcept { return m_database; }

private:
    sqlite3* m_database = nullptr;
};

}  // namespace terravox::boxes
