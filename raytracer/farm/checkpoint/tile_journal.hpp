#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "raytracer/farm/checkpoint/picture_key.hpp"
#include "raytracer/farm/checkpoint/records.hpp"

namespace terravox::farm {

/// The finished tiles of one picture in a file, as they were when it was opened. Opening reads the
/// whole file once and checks every tile; only the positions of tiles are kept in memory. Of
/// several versions of a tile the last one is used. Not thread-safe.
class TileJournal {
public:
    /// @throws Error where the file cannot be read, is no checkpoint, or its head is damaged
    explicit TileJournal(OpenFile file);

    struct Entry {
        std::uint64_t offset = 0;  ///< 0: the tile is not there
        std::uint32_t bytes = 0;
        std::uint32_t holes = 0;
        [[nodiscard]] bool is_there() const noexcept { return offset != 0; }
    };
    [[nodiscard]] const PictureKey& key() const noexcept { return m_key; }
    [[nodiscard]] const OpenFile& file() const noexcept { return m_file; }
    [[nodiscard]] const Entry& at(std::uint32_t cell) const { return m_entries.at(cell); }
    /// Number of tiles in the file.
    [[nodiscard]] std::uint32_t count() const noexcept { return m_count; }
    /// Which of the world's data the picture's coordinators could not read, one line each.
    [[nodiscard]] const std::set<std::string>& damage() const noexcept { return m_damage; }

    /// The bytes made by encode_tile.
    /// @param cell of a tile that is present
    /// @throws Error where they cannot be read
    [[nodiscard]] std::vector<std::byte> encoded(std::uint32_t cell) const;
    /// @throws Error for damage since the file was opened, and for invalid pixels
    [[nodiscard]] tiles::TileResult tile(std::uint32_t cell) const;

    /// A message of one line about damage; empty: none. A damaged tile that is also present
    /// undamaged is not counted.
    [[nodiscard]] std::string what_is_damaged() const;
    /// End of the valid part of the file; after it there may be an incomplete record of a
    /// coordinator that was killed.
    [[nodiscard]] std::uint64_t end() const noexcept { return m_end; }

    /// Registers a record that the writer of the file has appended.
    void note(const Record& record, std::uint32_t holes);
    void note_damage(const std::string& lines);

private:
    bool take(const Record& record, std::span<const std::byte> payload);
    OpenFile m_file;
    PictureKey m_key;
    std::vector<Entry> m_entries;  ///< by cell
    std::uint32_t m_count = 0;
    std::set<std::string> m_damage;
    std::set<std::uint32_t> m_damaged;  ///< cells
    std::uint64_t m_lost_bytes = 0;
    std::uint64_t m_end = 0;
};

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
