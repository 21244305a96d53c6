#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/box_builder.hpp"

namespace terravox::voxel::archive {

inline constexpr int kZstdLevel = 9;  ///< of boxes: written once, read often

/// A box for an archive, or the reason why there is none.
struct MadeBox {
    std::shared_ptr<const Box> box;   ///< nullptr: air, or a hole
    std::optional<std::string> hole;  ///< the reason, not empty; nullopt: no hole
};

/// What is written of a made box.
struct MadeRecord {
    BoxKey key;
    Kind kind = Kind::kBox;
    std::vector<std::byte> frame;  ///< empty: air, which is not written
};
[[nodiscard]] MadeRecord make_record(const BoxKey& key, const MadeBox& made);

/// A coarse box from its children; a hole if one of them is.
[[nodiscard]] MadeBox coarse_box(const BoxKey& key, const Pyramid::Children<MadeBox>& children);

/// A record of an earlier archive that is still what its children give; nullopt: it must be made.
/// Called on several threads.
using KeptRecord = std::function<std::optional<MadeRecord>(const BoxKey&)>;

/// Adds the boxes of levels below + 1 to levels - 1, level by level in the order of their keys,
/// from those of the level `below` that the writer has: kSubtreeLevel or more, or the coarsest.
/// @param threads 0: one for each core; the bytes do not depend on it
/// @param kept records that need not be made; empty: none
/// @throws Error when what was written cannot be read back
void add_levels_above(ArchiveWriter& writer, int below, int levels, int threads,
                      const KeptRecord& kept = {});

}  // namespace terravox::voxel::archive
