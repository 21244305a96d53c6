#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "raytracer/farm/checkpoint/part.hpp"
#include "raytracer/farm/checkpoint/tile_journal.hpp"

namespace terravox::farm {

/// Where the tiles of a picture that is not finished are kept: "out.exr.tiles"; of one part
/// "out.exr.part-2-of-5.tiles".
[[nodiscard]] std::filesystem::path checkpoint_path(const std::filesystem::path& picture,
                                                    const std::optional<Part>& part = std::nullopt);

/// Pictures that can be gone on with: those of a single pass whose samples do not depend on the
/// time. @throws UsageError naming the field
void check_can_checkpoint(const scene::Scene& scene);

/// The finished tiles of a picture on the disk, as they come, so that a coordinator that ends in
/// any way is gone on with. A tile is in the file as soon as add() returns (it outlives the
/// process), and on the disk a second later, or when the next one comes (it outlives the machine).
/// The file grows and is never rewritten. Not thread-safe.
///
/// The file is locked (flock) as long as the object lives, so that a second coordinator with the
/// same picture is told and does not mix its tiles in; the system frees the lock however the
/// process ends. Where a file system knows no locks, that is warned of.
class Checkpoint {
public:
    enum class Existing : bool {
        kGoOn,    ///< what is there is gone on with
        kRefuse,  ///< there must be none yet
    };
    /// Opens or begins the file. What a coordinator left that was killed in mid-write is cut off;
    /// damaged tiles count as not done, and are warned of. Tiles with holes count as not done, too:
    /// their boxes may be had by now.
    /// @throws Error for one that another coordinator writes to, that is of another picture (and
    /// what differs), or cannot be written; UsageError for kRefuse where there is one
    Checkpoint(std::filesystem::path path, const PictureKey& key, Existing existing);
    /// Without finish() or close() the file stays, unless there is nothing in it.
    ~Checkpoint();
    Checkpoint(const Checkpoint&) = delete;
    Checkpoint& operator=(const Checkpoint&) = delete;

    /// Tiles that are done, row by row from the upper left, read from the disk one at a time. Their
    /// RenderTile::index is that of the run that rendered them. To be called before has(): a tile
    /// whose pixels cannot be is warned of, and is not done any more. @throws Error
    void each(const std::function<void(tiles::TileResult&&)>& take);
    /// @param tile of a plan of a single pass, in any order
    [[nodiscard]] bool has(const tiles::RenderTile& tile) const;
    [[nodiscard]] std::uint32_t count() const noexcept {
        return m_journal->count() - m_with_holes;
    }  ///< tiles that are done
    [[nodiscard]] std::uint32_t with_holes() const noexcept {
        return m_with_holes;
    }  ///< tiles that were there and are to be rendered again

    /// A whole tile; it takes the place of what was there of it. Where this throws, all that was
    /// added before stays good.
    /// @throws Error for a disk that is full: the picture ends there, and goes on from there once
    /// there is room
    void add(const tiles::TileResult& result);
    /// The same for bytes that decode_tile has taken.
    void add_encoded(std::span<const std::byte> bytes);
    /// The tile is to be rendered again: whoever rendered it is not to be trusted. @throws Error
    void forget(const tiles::RenderTile& tile);
    /// What of the world's data could not be read so far (voxel::World::damage): lines that are not
    /// there yet. To be called before the tiles that suffer are added. @throws Error
    void note_damage(const std::vector<std::string>& lines);
    /// All such lines, those of earlier runs too, sorted.
    [[nodiscard]] std::vector<std::string> damage() const {
        return {m_journal->damage().begin(), m_journal->damage().end()};
    }

    void finish();  ///< the picture stands: the file goes @throws Error
    void
    close();  ///< the file stays, and is on the disk; nothing may be added any more @throws Error

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }

private:
    Record append(RecordKind kind, std::uint32_t cell, std::span<const std::byte> payload);
    [[nodiscard]] std::uint32_t cell_of(const tiles::RenderTile& tile) const;
    void flush();
    const std::filesystem::path m_path;
    std::optional<TileJournal> m_journal;
    std::uint64_t m_end = 0;  ///< of the file
    std::uint32_t m_with_holes = 0;
    std::vector<bool> m_again;  ///< by cell: there, but to be rendered again
    std::chrono::steady_clock::time_point m_flushed = std::chrono::steady_clock::now();
    bool m_open = true, m_dirty = false, m_empty = false;
};

}  // namespace terravox::farm
