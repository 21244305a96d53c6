#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "voxelserver/make/worlds/minecraft/place_names.hpp"
#include "voxelserver/make/worlds/minecraft/source.hpp"

namespace terravox::minecraft {

/// The contents of level.dat. What it lacks is empty.
struct LevelDat {
    std::string name;                          ///< UTF-8
    std::string version;                       ///< e.g. "1.16.4"
    std::optional<std::int64_t> data_version;  ///< e.g. 2584; since 1.9
    std::optional<std::array<std::int64_t, 3>> spawn;
    std::optional<std::int64_t> seed;
};

/// @param file gzip, zlib or bare NBT
/// @param origin names it in messages
/// @throws Error
[[nodiscard]] LevelDat read_level_dat(std::span<const std::uint8_t> file,
                                      const std::string& origin);

/// A file that holds chunks.
struct ChunkFile {
    std::size_t entry = 0;  ///< in the source
    FileKind kind = FileKind::kAnvil;
    std::int32_t x = 0, z = 0;  ///< of the region or the chunk
    bool placed = true;         ///< false: x, z are to be read from its chunks
};

/// One dimension of a world: where its chunks are.
struct DimensionFolder {
    std::string name;
    std::string folder;
    std::vector<ChunkFile> files;    ///< by x, then z
    std::vector<std::string> notes;  ///< files that were skipped, and why
};

/// The parts of a world, found by the names of its files. Immutable except for the source, which is
/// thread-safe.
class WorldFolder {
public:
    /// @param path as MinecraftWorldOptions::path
    /// @param cache_bytes of files kept open or unpacked
    /// @throws UsageError when no world, or more than one, is there; Error when it cannot be read
    WorldFolder(const std::filesystem::path& path, std::size_t cache_bytes);

    [[nodiscard]] FileSource& source() const noexcept { return *m_source; }
    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }
    /// Folder of the source that holds the world.
    [[nodiscard]] const std::string& root() const noexcept { return m_root; }
    [[nodiscard]] std::string title() const;  ///< level.dat's name, else the file's or folder's
    [[nodiscard]] const std::optional<LevelDat>& level() const noexcept { return m_level; }
    /// Damage of files that belong to no dimension.
    [[nodiscard]] const std::vector<std::string>& damage() const noexcept { return m_damage; }
    /// Text of terravox.json, when there is one.
    [[nodiscard]] const std::optional<std::string>& side_car() const noexcept { return m_side_car; }
    /// The overworld first, then by name.
    [[nodiscard]] const std::vector<DimensionFolder>& dimensions() const noexcept {
        return m_dimensions;
    }
    /// @throws UsageError naming the available ones
    [[nodiscard]] const DimensionFolder& dimension(std::string_view name) const;

private:
    void add_single_file();
    void find_root();
    void read_level();
    void collect();
    void pass_over_second_places();
    /// @throws UsageError for a world of the Bedrock edition
    void refuse_bedrock() const;
    void refuse_linear() const;
    DimensionFolder& dimension_at(std::string_view folder);

    std::filesystem::path m_path;
    std::unique_ptr<FileSource> m_source;
    std::string m_root;
    std::optional<LevelDat> m_level;
    std::optional<std::string> m_side_car;
    std::vector<std::string> m_damage;
    std::vector<DimensionFolder> m_dimensions;
};

}  // namespace terravox::minecraft
