#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/voxelize/points/square_info.hpp"
#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"

namespace terravox::voxelize {

/// What is known of an opened LiDAR world apart from its boxes: small enough to be kept, so that a
/// server can describe a world, and serve cached boxes, before the world is opened again. The
/// opened world answers from the same facts. Plain data; const functions may be called
/// concurrently.
struct WorldFacts {
    voxel::WorldInfo info;
    std::vector<grid::ColumnRect> islands;  ///< elsewhere there is nothing
    std::vector<SquareInfo> squares;        ///< by path; all of them in the state kFetched
    std::uint64_t orthophotos = 0;          ///< their number
    double water_cell_m = 0;
    InputFingerprints fingerprints;

    /// The extent of a column of boxes, as World::column().
    /// @throws UsageError for a level that the world does not have
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) const;
    /// The fingerprint of a box, as ProvenanceWorld::fingerprint().
    [[nodiscard]] voxel::Fingerprint fingerprint(const voxel::InputExtent& reach) const {
        return fingerprints.fingerprint(reach);
    }
    /// Whether the columns of a box may hold anything.
    [[nodiscard]] bool touches_land(int level, std::int32_t bx, std::int32_t bz) const noexcept;
};

/// The first bytes of serialized facts; the last character is the version of the layout.
inline constexpr std::string_view kFactsMagic = "TVFACTS3";

/// Facts as bytes: versioned, with a checksum, the same on every machine.
[[nodiscard]] std::string to_bytes(const WorldFacts& facts);
/// @param bytes from any source
/// @throws Error for bytes that are damaged, of another version, or not facts
[[nodiscard]] WorldFacts facts_from_bytes(std::string_view bytes);

/// A name (32 hexadecimal digits) for everything that opening a world reads: options, the values of
/// class table, settings and palette, and of every LiDAR file and orthophoto its path, size, time,
/// beginning and end. Worlds of one name have the same facts. Memory, threads and cache folder are
/// not part of it. Costs some 50 microseconds a file; needs no library that reads them.
/// @param opener the file that holds the code that opens worlds (module/), since another version
/// may open them differently; empty = it is not part of the name
/// @throws what open_lidar_world throws for missing files and bad tables
[[nodiscard]] std::string world_name(const LidarWorldOptions& options,
                                     const std::filesystem::path& opener = {});

}  // namespace terravox::voxelize
