#pragma once

#include <cstdint>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/data/grid/patch.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/points/tints.hpp"

namespace terravox::voxelize {

/// Must be raised whenever the same inputs make other voxels than before: boxes, and the light of
/// photographs, kept by older programs are then made again.
inline constexpr std::uint32_t kBoxRecipe = 7;

/// The extent of a patch and `around` patches on each side.
[[nodiscard]] constexpr voxel::InputExtent measure_reach(grid::PatchKey key,
                                                         std::int32_t around = 0) noexcept {
    return {key.px - around, key.pz - around, key.px + 1 + around, key.pz + 1 + around};
}
/// The inputs of boxes, as fingerprints of their contents. Each file affects only the boxes near
/// it; everything else affects every box. Folders and the order of arguments do not count, except
/// that the order of images counts where they overlap. Plain data; fingerprint() may be called
/// concurrently.
struct InputFingerprints {
    struct Input {
        grid::ColumnRect rect;  ///< no column outside depends on the file
        voxel::Fingerprint fingerprint{};
        bool coloured = false;  ///< surfaces may take materials from its colours
    };
    /// Box recipe, frame, settings, class table, tints, and values derived from all files.
    voxel::Fingerprint everywhere{};
    voxel::Fingerprint palette{};  ///< counts where there are colours
    std::vector<Input> points;     ///< by fingerprint
    std::vector<Input> images;     ///< by precedence: the image that wins comes first

    /// See voxel::ProvenanceWorld. Takes some nanoseconds for each file.
    [[nodiscard]] voxel::Fingerprint fingerprint(const voxel::InputExtent& reach) const;
};

/// Fingerprints of the values of a class table and of tints, and of the palette that settings name:
/// not of their files' text.
[[nodiscard]] voxel::Fingerprint to_fingerprint(const ClassTable& classes);
[[nodiscard]] voxel::Fingerprint palette_fingerprint(const Settings& settings);
[[nodiscard]] voxel::Fingerprint to_fingerprint(const Tints& tints);

}  // namespace terravox::voxelize

namespace terravox::imagery {
class Orthophotos;
}  // namespace terravox::imagery

namespace terravox::voxelize {

struct Sources;

/// InputFingerprints::everywhere of an opened world.
[[nodiscard]] voxel::Fingerprint fingerprint_everywhere(const Sources& sources,
                                                        const ClassTable& classes,
                                                        const Settings& settings, int cell_voxels);

/// The fingerprints of an opened world.
/// @param images nullptr = none
[[nodiscard]] InputFingerprints make_fingerprints(const Sources& sources,
                                                  const imagery::Orthophotos* images,
                                                  const ClassTable& classes,
                                                  const Settings& settings, int cell_voxels);

}  // namespace terravox::voxelize
