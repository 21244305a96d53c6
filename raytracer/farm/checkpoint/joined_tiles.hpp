#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "raytracer/farm/checkpoint/tile_journal.hpp"

namespace terravox::farm {

/// The tiles of one picture from the checkpoints of several coordinators. Not thread-safe.
class JoinedTiles {
public:
    /// Opens all files and compares tiles that are in more than one. A tile without holes is
    /// preferred to one with holes.
    /// @throws Error for a file that cannot be read or that a coordinator is still writing to, for
    /// files of different pictures, and for unequal tiles without holes, naming both files and the
    /// difference
    explicit JoinedTiles(const std::vector<std::filesystem::path>& files);

    [[nodiscard]] const PictureKey& key() const noexcept { return m_journals.front().key(); }
    [[nodiscard]] std::uint32_t count() const noexcept { return m_count; }
    [[nodiscard]] std::uint32_t missing() const noexcept { return key().grid.cells() - m_count; }
    /// Rows of tiles, counted from 1 at the top, in which some are missing: "2 to 5, 9". Empty when
    /// none are.
    [[nodiscard]] std::string rows_missing() const;
    [[nodiscard]] std::vector<std::string> damage() const {
        return {m_damage.begin(), m_damage.end()};
    }

    /// Visits the tiles row by row from the upper left, with one in memory at a time.
    /// @throws Error
    void each(const std::function<void(tiles::TileResult&&)>& take) const;
    /// Writes all tiles to a checkpoint of its own, which appears under its name once it is whole.
    /// @throws Error; UsageError if a file of that name exists, even an empty one
    void write(const std::filesystem::path& file) const;

private:
    static constexpr std::uint32_t kNoJournal = ~0U;
    void compare(std::uint32_t cell, std::uint32_t other);
    std::vector<TileJournal> m_journals;
    std::vector<std::uint32_t> m_journal_of;  ///< by cell: index of the journal that holds the tile
    std::uint32_t m_count = 0;
    std::set<std::string> m_damage;
};

/// Rows of tiles in which some are missing, as JoinedTiles::rows_missing.
/// @param is_there (cell)
[[nodiscard]] std::string rows_missing(const TileGrid& grid,
                                       const std::function<bool(std::uint32_t)>& is_there);

}  // namespace terravox::farm
