#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace terravox::store {

/// What a store says of one of its squares.
enum class StoredState : std::uint8_t {
    kWanted,   ///< asked for, not whole yet
    kFetched,  ///< its file is there
    kFailed,   ///< see `error`
    kMissing,  ///< its source has no such square
};

/// Version of the store's tables that is understood: the number of files in grabber/migrations.
inline constexpr int kGrabberSchema = 3;

/// A rectangle of ground, in the units of the square's CRS.
struct StoredBounds {
    std::array<double, 3> min{}, max{};
};

struct StoredSquare {
    std::string name;    ///< such as 462_101
    std::string source;  ///< id of the source
    StoredState state = StoredState::kWanted;
    std::filesystem::path file;  ///< where it lies; empty unless fetched
    std::uint64_t bytes = 0, points = 0;
    std::optional<StoredBounds> bounds;
    std::string crs, class_table, licence, attribution;  ///< empty = not recorded
    std::string error;                                   ///< one line; empty = none
};

/// What a store that the grabber fills holds now.
struct GrabberStore {
    std::vector<StoredSquare> squares;               ///< by source, then name; each once
    std::vector<std::filesystem::path> orthophotos;  ///< files of those that can be used, by path
    /// The files of all fetched squares.
    [[nodiscard]] std::vector<std::filesystem::path> files() const;
};

/// Reads a store, also while the grabber works in it; how it keeps its list of squares is nobody
/// else's matter. Squares that are only known to exist are left out. A square whose file has gone
/// or has another length than it had when it was fetched has failed, unless it is being fetched
/// again; such an orthophoto is left out with a warning. A store that is only just being filled has
/// no squares.
/// @param folder as given to `grabber fetch --store`
/// @throws Error when there is no such folder, it is no store or one of another version, or its
/// list cannot be read or says what cannot be
[[nodiscard]] GrabberStore read_grabber_store(const std::filesystem::path& folder);

[[nodiscard]] const char* name_of(
    StoredState state) noexcept;  ///< "wanted", "fetched", "failed", "missing"

}  // namespace terravox::store
