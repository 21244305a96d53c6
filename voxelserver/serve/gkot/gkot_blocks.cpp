#include "voxelserver/serve/gkot/gkot_blocks.hpp"

namespace terravox::gkot {

std::uint32_t block_word(voxel::Material material) noexcept {
    const voxel::OldBlock block = voxel::traits_of(material).old_block;
    return std::uint32_t{block.data} << 8 | block.id;
}

}  // namespace terravox::gkot
