#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "voxelserver/data/sqlite/statement.hpp"
#include "voxelserver/data/sqlite/untrusted_database.hpp"

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
    /// @throws Error, as its steps
    [[nodiscard]] sqlite::Statement query(const char* sql);

private:
    [[noreturn]] void fail() const;  ///< @throws Error with SQLite's message

    std::string m_attempt;  ///< begins messages
    int m_callbacks_left;  ///< remaining calls of the progress handler, for all statements together
    sqlite::Connection m_database;
};

/// The state of a square in a store.
enum class StoredState : std::uint8_t {
    kWanted,   ///< requested, not complete yet
    kFetched,  ///< its file is present
    kFailed,   ///< see `error`
    kMissing,  ///< its source has no such square
};

/// Supported version of the store's schema: the number of files in grabber/migrations.
inline constexpr int kGrabberSchema = 3;

/// A rectangle of ground.
struct StoredBounds {
    std::array<double, 3> min{};
    std::array<double, 3> max{};
};

struct StoredSquare {
    std::string name;    ///< such as 462_101
    std::string source;  ///< id of the source
    StoredState state = StoredState::kWanted;
    std::filesystem::path file;  ///< location of the file; empty unless fetched
    std::uint64_t bytes = 0;
    std::uint64_t points = 0;
    std::optional<StoredBounds> bounds;
    /// That of the bounds, or of the place in the name; empty = not recorded. Those of a catalogue
    /// may be in another one than the file.
    std::string bounds_crs;
    std::string crs, class_table, licence, attribution;  ///< empty = not recorded
    std::string error;                                   ///< one line; empty = none
};

/// An orthophoto that can be used.
struct StoredOrthophoto {
    std::filesystem::path file;
    std::string licence, attribution;  ///< empty = not recorded
};

/// The current content of a store that the grabber fills.
struct GrabberStore {
    std::vector<StoredSquare> squares;          ///< sorted by source, then name; no duplicates
    std::vector<StoredOrthophoto> orthophotos;  ///< sorted by path
    std::filesystem::path folder;               ///< as given to read_grabber_store()
    /// The fetched squares: those with a file. Valid as long as `squares` is not changed.
    [[nodiscard]] std::vector<const StoredSquare*> fetched() const;
};

/// Reads a store, also while the grabber is writing to it; its database schema is used nowhere
/// else. Squares that are only known to exist are omitted. A square whose file is missing or has
/// another length than it had when it was fetched counts as failed, unless it is being fetched
/// again; such an orthophoto is omitted with a warning. A store that has just been created has no
/// squares.
/// @param folder as given to `grabber fetch --store`
/// @throws Error when the folder does not exist, is not a store or has another version, or when its
/// list cannot be read or contains invalid values
[[nodiscard]] GrabberStore read_grabber_store(const std::filesystem::path& folder);

/// "wanted", "fetched", "failed", "missing".
[[nodiscard]] const char* to_name(StoredState state) noexcept;

}  // namespace terravox::store
