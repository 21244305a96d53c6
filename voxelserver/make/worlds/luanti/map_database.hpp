#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/data/sqlite/statement.hpp"
#include "voxelserver/data/sqlite/untrusted_database.hpp"
#include "voxelserver/make/worlds/luanti/map_block.hpp"

namespace terravox::luanti {

/// The blocks of a map.sqlite, of both schemas (a number that encodes the place, or x, y and z). A
/// server may be writing to the file: it is opened read-only, no transaction stays open between two
/// calls, and a lock held by the server is waited for for some seconds. Nothing is made or changed
/// next to the file, which may lie on a read-only disk. Thread-safe.
class MapDatabase {
public:
    /// @throws Error when it is not a database, or has no table of blocks with a known key
    explicit MapDatabase(const std::filesystem::path& file);
    MapDatabase(const MapDatabase&) = delete;
    MapDatabase& operator=(const MapDatabase&) = delete;

    /// Calls visit for the place of every block, in unspecified order, reading only the keys.
    /// @return how many keys are outside any world; visit is not called for these
    /// @throws Error when it cannot be read to its end, or changes meanwhile
    std::uint64_t for_each_place(const std::function<void(const BlockPlace&)>& visit);

    /// @return the stored bytes; empty: there is no such block
    /// @throws Error when it cannot be read
    [[nodiscard]] std::vector<std::uint8_t> read(const BlockPlace& place);

    /// Whether a block's place is one number in this file.
    [[nodiscard]] bool is_key_encoded() const noexcept { return m_encoded; }

private:
    struct FileState {
        std::uint64_t bytes = 0;
        std::filesystem::file_time_type changed;
        bool is_settled = false;
        friend bool operator==(const FileState&, const FileState&) = default;
    };
    void open();
    void find_schema();
    [[nodiscard]] sqlite::Statement prepare(const char* sql);
    [[nodiscard]] FileState state() const;
    [[nodiscard]] bool has_changed() const;
    [[nodiscard]] std::vector<std::uint8_t> read_now(const BlockPlace& place);
    [[noreturn]] void fail() const;

    const std::filesystem::path m_file;
    const std::string m_attempt;  ///< begins messages
    std::mutex m_mutex;  ///< guards everything below: one connection, used by one thread at a time
    /// The state of a file that was opened as one that nobody writes to; nullopt: SQLite takes
    /// care.
    std::optional<FileState> m_settled;
    sqlite::Connection m_database;
    bool m_encoded = false;  ///< the key is one number
    std::unique_ptr<sqlite::Statement> m_select;
};

}  // namespace terravox::luanti
