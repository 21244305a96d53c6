#pragma once

#include <cstdint>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/grid/patch.hpp"
#include "voxelserver/voxelize/points/class_table.hpp"
#include "voxelserver/voxelize/points/settings.hpp"

namespace terravox::voxelize {

/// To be raised whenever the same inputs make other voxels than before: boxes kept by older
/// programs are made again then.
inline constexpr std::uint32_t kBoxRecipe = 1;

/// A patch, and so many patches on each side.
[[nodiscard]] constexpr voxel::InputExtent reach_of(grid::PatchKey key,
                                                    std::int32_t around = 0) noexcept {
    return {key.px - around, key.pz - around, key.px + 1 + around, key.pz + 1 + around};
}
/// What boxes are made of, as numbers that stand for contents. Files lie somewhere; everything else
/// shapes every box. Folders have no part in it, nor has the order of arguments; that of images has
/// where images overlap. Plain data; fingerprint() may be called at once.
struct InputFingerprints {
    struct Input {
        grid::ColumnRect rect;  ///< no column outside depends on the file
        voxel::Fingerprint print{};
        bool coloured = false;  ///< surfaces may take materials from its colours
    };
    voxel::Fingerprint everywhere{};  ///< way of making, frame, settings, class table, what is
                                      ///< derived from all files
    voxel::Fingerprint palette{};     ///< counts where there are colours
    std::vector<Input> points;        ///< by print
    std::vector<Input> images;        ///< the one that wins first

    /// See voxel::ProvenanceWorld. Some nanoseconds for each file.
    [[nodiscard]] voxel::Fingerprint fingerprint(const voxel::InputExtent& reach) const;
};

/// The values of a class table, and of the palette that settings name: not their files' text.
[[nodiscard]] voxel::Fingerprint print_of(const ClassTable& classes);
[[nodiscard]] voxel::Fingerprint palette_print(const Settings& settings);

}  // namespace terravox::voxelize
