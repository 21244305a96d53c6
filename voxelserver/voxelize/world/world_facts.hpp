#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "voxelserver/voxelize/points/square_info.hpp"
#include "voxelserver/voxelize/world/input_fingerprints.hpp"

namespace terravox::voxelize {

/// What is known of an opened LiDAR world apart from its boxes: small enough to be kept, so that a
/// server can tell about a world, and hand out boxes it has kept, before the world is opened again.
/// The opened world answers from the same facts. Plain data; const functions may be called at once.
struct WorldFacts {
    voxel::WorldInfo info;
    std::vector<grid::ColumnRect> islands;  ///< elsewhere is nothing
    std::vector<SquareInfo> squares;        ///< by path; all of them in the state kFetched
    std::uint64_t orthophotos = 0;          ///< how many
    double water_cell_m = 0;
    InputFingerprints prints;

    /// As World::column(). @throws UsageError for a level that the world has not
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) const;
    /// As ProvenanceWorld::fingerprint().
    [[nodiscard]] voxel::Fingerprint fingerprint(const voxel::InputExtent& reach) const {
        return prints.fingerprint(reach);
    }
    /// Whether there may be anything in the columns of a box.
    [[nodiscard]] bool touches_land(int level, std::int32_t bx, std::int32_t bz) const noexcept;
    /// @throws UsageError for a level that the world has not
    void check_level(int level) const;
};

inline constexpr std::string_view kFactsMagic =
    "TVFACTS1";  ///< how facts begin; the last character is the version of the layout

/// Facts as bytes: versioned, with a checksum, the same on every machine.
[[nodiscard]] std::string to_bytes(const WorldFacts& facts);
/// @param bytes from anywhere @throws Error for bytes that are damaged, of another version, or no
/// facts
[[nodiscard]] WorldFacts facts_from_bytes(std::string_view bytes);

}  // namespace terravox::voxelize
