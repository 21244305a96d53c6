#include "voxelserver/data/sqlite/untrusted_database.hpp"

#include <sqlite3.h>

#include <algorithm>
#include <system_error>

#include "common/util/error.hpp"

namespace terravox::sqlite {
namespace {

constexpr int kBusyTimeout_ms = 10'000;  // while another process recovers or checkpoints

/// Escapes the characters of a file name that have a meaning in SQLite's URIs.
std::string to_uri(const std::filesystem::path& file, bool immutable) {
    std::string out = "file:";
    constexpr char kHex[] = "0123456789ABCDEF";
    for (const unsigned char c : std::filesystem::absolute(file).string()) {
        if (c == '%' || c == '?' || c == '#') {
            out += '%';
            out += kHex[c >> 4];
            out += kHex[c & 15];
        } else {
            out += static_cast<char>(c);
        }
    }
    // The index of a write-ahead log is memory that is shared through a file, which SQLite would
    // make, and leave behind.
    return out + (immutable ? "?immutable=1" : "?readonly_shm=1");
}

}  // namespace

bool is_settled(const std::filesystem::path& file) {
    std::error_code failed;
    const auto bytes = std::filesystem::file_size(file.string() + "-wal", failed);
    return failed || bytes == 0;
}

void CloseDatabase::operator()(sqlite3* database) const noexcept {
    sqlite3_close(database);
}

Connection open_untrusted(const std::filesystem::path& file, const UntrustedFileOptions& options,
                          const std::string& attempt) {
    std::error_code failed;
    if (!options.immutable && !is_settled(file) &&
        !std::filesystem::exists(file.string() + "-shm", failed))
        throw util::Error(attempt +
                          ": it has a write-ahead log (-wal), but not the file (-shm) by which "
                          "that is read; allowed: both, or neither, as they are once the program "
                          "that writes it has closed it");
    const int flags =
        SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_NOMUTEX | SQLITE_OPEN_PRIVATECACHE;
    sqlite3* opened = nullptr;
    const int code =
        sqlite3_open_v2(to_uri(file, options.immutable).c_str(), &opened, flags, nullptr);
    Connection out(opened);
    if (code != SQLITE_OK)
        throw util::Error(attempt + ": " + last_error(opened));
    sqlite3_busy_timeout(opened, kBusyTimeout_ms);
    sqlite3_limit(opened, SQLITE_LIMIT_LENGTH, options.max_value_bytes);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_DEFENSIVE, 1, nullptr);
    sqlite3_db_config(opened, SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0, nullptr);
    return out;
}

std::string last_error(sqlite3* database) {
    if (database == nullptr)
        return "out of memory";
    std::string text = sqlite3_errmsg(database);
    std::replace_if(
        text.begin(), text.end(), [](unsigned char c) { return c < ' ' || c > '~'; }, ' ');
    return text.substr(0, 300);
}

}  // namespace terravox::sqlite
