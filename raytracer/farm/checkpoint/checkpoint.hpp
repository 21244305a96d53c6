#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "raytracer/farm/checkpoint/tile_journal.hpp"

namespace terravox::farm {

/// One of several coordinators' shares of a picture's tiles: "2/5" is the second of five. Every
/// tile belongs to exactly one part. Parts are interleaved in both directions, so that each has its
/// share of sky, ground and expensive regions.
struct Part {
    static constexpr std::uint32_t kMaxParts = 65'536;
    static constexpr const char* kAllowed = "I/N, part I of N, 1/1 to 65536/65536";

    std::uint32_t index = 1, count = 1;  ///< 1 <= index <= count

    /// @return nullopt for anything but kAllowed
    [[nodiscard]] static std::optional<Part> parse(const std::string& text);
    /// @param column, row of the tile in its grid
    [[nodiscard]] bool has(std::uint32_t column, std::uint32_t row) const noexcept;
    friend bool operator==(const Part&, const Part&) = default;
};

/// The file that keeps the tiles of an unfinished picture: "out.exr.tiles"; of one part
/// "out.exr.part-2-of-5.tiles".
[[nodiscard]] std::filesystem::path checkpoint_path(const std::filesystem::path& picture,
                                                    const std::optional<Part>& part = std::nullopt);

/// Checks that a picture can be resumed: it must have a single pass, and its samples must not
/// depend on time.
/// @throws UsageError naming the field
void check_can_checkpoint(const scene::Scene& scene);

/// The finished tiles of a picture on disk, written as they arrive, so that a picture can be
/// resumed however its coordinator ended. A tile is in the file when add() returns (it survives the
/// process), and on the disk a second later, or when the next one arrives (it survives the
/// machine). The file grows and is never rewritten. Not thread-safe.
///
/// The file is locked (flock) while the object lives, so that a second coordinator of the same
/// picture gets an error and does not mix its tiles in; the system releases the lock however the
/// process ends. Where a file system does not support locks, a warning is logged.
class Checkpoint {
public:
    enum class Existing : bool {
        kResume,  ///< existing tiles are reused
        kRefuse,  ///< there must be no file yet
    };
    /// Opens or creates the file. An incomplete record of a coordinator that was killed while
    /// writing is cut off; damaged tiles count as not done, with a warning. Tiles with holes also
    /// count as not done: their boxes may be available by now.
    /// @throws Error for a file that another coordinator writes to, that is of another picture
    /// (naming the difference), or that cannot be written; UsageError for kRefuse if the file
    /// exists
    Checkpoint(std::filesystem::path path, const PictureKey& key, Existing existing);
    /// Without finish() or close() the file stays, unless it is empty.
    ~Checkpoint();
    Checkpoint(const Checkpoint&) = delete;
    Checkpoint& operator=(const Checkpoint&) = delete;

    /// Visits the finished tiles, row by row from the upper left, read from the disk one at a time.
    /// Their RenderTile::index is that of the run that rendered them. To be called before has(): a
    /// tile with invalid pixels is reported with a warning and then counts as not done.
    /// @throws Error
    void each(const std::function<void(tiles::TileResult&&)>& take);
    /// @param tile of a plan of a single pass, in any order
    [[nodiscard]] bool has(const tiles::RenderTile& tile) const;
    /// Number of tiles that are done.
    [[nodiscard]] std::uint32_t count() const noexcept { return m_journal->count() - m_with_holes; }
    /// Number of tiles in the file that must be rendered again, as they have holes.
    [[nodiscard]] std::uint32_t with_holes() const noexcept { return m_with_holes; }

    /// Adds a whole tile, replacing an earlier version of it. If this throws, everything added
    /// before remains valid.
    /// @throws Error for a full disk: the picture ends there, and can be resumed once there is
    /// space
    void add(const tiles::TileResult& result);
    /// The same for bytes that decode_tile has accepted.
    void add_encoded(std::span<const std::byte> bytes);
    /// Marks the tile to be rendered again, because its maker turned out not to be trustworthy.
    /// @throws Error
    void forget(const tiles::RenderTile& tile);
    /// Records which of the world's data could not be read so far (voxel::World::damage); lines
    /// already recorded are skipped. To be called before the affected tiles are added.
    /// @throws Error
    void note_damage(const std::vector<std::string>& lines);
    /// All such lines, including those of earlier runs, sorted.
    [[nodiscard]] std::vector<std::string> damage() const {
        return {m_journal->damage().begin(), m_journal->damage().end()};
    }

    /// Removes the file, because the picture is complete.
    /// @throws Error
    void finish();
    /// Flushes the file to the disk and keeps it; nothing may be added afterwards.
    /// @throws Error
    void close();

    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }

private:
    Record append(RecordKind kind, std::uint32_t cell, std::span<const std::byte> payload);
    [[nodiscard]] std::uint32_t find_cell(const tiles::RenderTile& tile) const;
    void flush();
    const std::filesystem::path m_path;
    std::optional<TileJournal> m_journal;
    std::uint64_t m_end = 0;  ///< size of the file
    std::uint32_t m_with_holes = 0;
    std::vector<bool> m_again;  ///< by cell: present, but to be rendered again
    std::chrono::steady_clock::time_point m_flushed = std::chrono::steady_clock::now();
    bool m_open = true;
    bool m_dirty = false;
    bool m_empty = false;
};

}  // namespace terravox::farm
