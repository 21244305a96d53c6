#pragma once

#include <sqlite3.h>

#include <filesystem>
#include <stdexcept>
#include <string>

namespace terravox::test {

/// A database of SQLite, made where there is none, for as long as this lives.
class Database {
public:
    explicit Database(const std::filesystem::path& file) {
        if (sqlite3_open(file.string().c_str(), &m_database) != SQLITE_OK)
            throw std::runtime_error("open " + file.string());
    }
    ~Database() { sqlite3_close(m_database); }
    Database(const Database&) = delete;
    Database& operator=(const Database&) = delete;

    /// @throws std::runtime_error where a statement fails
    void run(const std::string& sql) {
        char* why = nullptr;
        if (sqlite3_exec(m_database, sql.c_str(), nullptr, nullptr, &why) == SQLITE_OK)
            return;
        const std::string message =
            (why != nullptr ? why : "?") + std::string(" in ") + sql.substr(0, 200);
        sqlite3_free(why);
        throw std::runtime_error(message);
    }

private:
    sqlite3* m_database = nullptr;
};

}  // namespace terravox::test
