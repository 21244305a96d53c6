#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace terravox::sqlite {

/// A prepared statement: bind, read columns while step() returns true, then reset() before the next
/// use. Parameters and columns are counted from 0. Not thread-safe.
class Statement {
public:
    /// Called when SQLite refuses something; throws.
    using Fail = std::function<void()>;

    /// @param database must outlive it
    /// @throws what `fail` throws, as step() and run()
    Statement(sqlite3* database, std::string_view sql, Fail fail);
    ~Statement();
    Statement(Statement&& other) noexcept;
    Statement(const Statement&) = delete;
    Statement& operator=(const Statement&) = delete;

    Statement& bind(int at, std::int64_t value);
    /// @param bytes nullptr: NULL; else must stay alive until reset()
    Statement& bind_bytes(int at, const std::string* bytes);
    /// @return whether there is a row
    [[nodiscard]] bool step();
    /// Runs to the end, and resets.
    void run();
    void reset() noexcept;

    // Columns of the current row; nullopt when the value has another type.
    [[nodiscard]] bool is_null(int column) const noexcept;
    [[nodiscard]] std::optional<std::int64_t> integer(int column) const noexcept;
    [[nodiscard]] std::optional<double> number(int column) const noexcept;  ///< finite
    [[nodiscard]] std::optional<std::string> text(int column) const;
    /// Valid until the next step() or reset().
    [[nodiscard]] std::optional<std::string_view> bytes(int column) const noexcept;
    /// What SQLite makes of a value of any type.
    [[nodiscard]] std::int64_t to_integer(int column) const noexcept;

private:
    Fail m_fail;
    sqlite3_stmt* m_statement = nullptr;
};

/// Resets a statement at the end of a scope, so that it holds no lock on the file.
class StatementReset {
public:
    explicit StatementReset(Statement& statement) : m_statement(statement) {}
    ~StatementReset() { m_statement.reset(); }
    StatementReset(const StatementReset&) = delete;
    StatementReset& operator=(const StatementReset&) = delete;

private:
    Statement& m_statement;
};

}  // namespace terravox::sqlite
