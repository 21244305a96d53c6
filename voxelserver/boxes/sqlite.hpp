#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "common/util/error.hpp"

namespace terravox::boxes {

/// SQLite says no.
class SqliteError : public util::Error {
public:
    enum class Why {
        kOther,
        kDamaged,
        kBusy
    };  ///< kDamaged: no database, or not a sound one; kBusy: another process holds it
    SqliteError(const std::string& message, Why why) : util::Error(message), m_why(why) {}
    [[nodiscard]] Why why() const noexcept { return m_why; }

private:
    Why m_why;
};

/// A prepared statement: bind, step until false, read columns; then reset() before the next use.
/// Not thread-safe.
class Statement {
public:
    Statement(sqlite3* database, std::string_view sql);  ///< @throws SqliteError
    ~Statement() { sqlite3_finalize(m_statement); }
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    Statement& bind(int at, std::int64_t value);  ///< @param at from 1
    Statement& bind_bytes(
        int at, const std::string* bytes);  ///< nullptr: NULL. The bytes must live until reset()
    /// @return whether there is a row @throws SqliteError
    bool step();
    void run() {  ///< steps to the end and resets
        while (step()) {
        }
        reset();
    }
    void reset() noexcept;

    [[nodiscard]] std::int64_t integer(int column) const {
        return sqlite3_column_int64(m_statement, column);
    }  ///< @param column from 0
    [[nodiscard]] std::shared_ptr<const std::string> bytes(int column) const;  ///< nullptr for NULL

private:
    sqlite3* m_database;
    sqlite3_stmt* m_statement = nullptr;
};

/// Resets a statement at the end of a block, whatever happens there.
class Resetting {
public:
    explicit Resetting(Statement& statement) : m_statement(statement) {}
    ~Resetting() { m_statement.reset(); }
    Resetting(const Resetting&) = delete;
    Resetting& operator=(const Resetting&) = delete;

private:
    Statement& m_statement;
};

/// A connection for one thread at a time.
class Database {
public:
    explicit Database(const std::string& file);  ///< made when it is not there @throws SqliteError
    ~Database() { sqlite3_close(m_database); }
    Database(const Database&) = delete;
    Database& operator=(const Database&) = delete;

    void run(const char* sql);  ///< one or more statements without parameters @throws SqliteError
    [[nodiscard]] std::int64_t number(const char* sql);  ///< the first column of the first row
    [[nodiscard]] sqlite3* get() const noexcept { return m_database; }

private:
    sqlite3* m_database = nullptr;
};

}  // namespace terravox::boxes
