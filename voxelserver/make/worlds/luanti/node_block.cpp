#include "voxelserver/make/worlds/luanti/node_block.hpp"

#include <algorithm>
#include <string>

#include "common/util/error.hpp"

namespace terravox::luanti {
namespace {

using voxel::VoxelAttr;

/// Index of an appearance in the list, to which it is added when it is new: names with the same one
/// share one.
std::uint16_t index_of(const VoxelAttr& appearance, std::vector<VoxelAttr>& appearances) {
    const auto found = std::find(appearances.begin(), appearances.end(), appearance);
    const auto index = static_cast<std::uint16_t>(found - appearances.begin());
    if (found == appearances.end())
        appearances.push_back(appearance);
    return index;
}

/// The entry of the names for an id.
std::size_t entry_of(std::uint16_t id, const std::vector<MapBlock::Name>& names) {
    const auto found =
        std::lower_bound(names.begin(), names.end(), id,
                         [](const MapBlock::Name& a, std::uint16_t b) { return a.id < b; });
    if (found == names.end() || found->id != id)
        throw util::Error("node id " + std::to_string(id) + " has no name");
    return static_cast<std::size_t>(found - names.begin());
}

}  // namespace

std::shared_ptr<const NodeBlock> node_block_of(const MapBlock& block,
                                               NodeAppearances& appearances) {
    auto out = std::make_shared<NodeBlock>();
    std::vector<std::uint16_t> appearance_of_entry;
    appearance_of_entry.reserve(block.names.size());
    for (const MapBlock::Name& entry : block.names)
        appearance_of_entry.push_back(index_of(appearances.of(entry.name), out->appearances));
    out->cells.resize(kBlockNodes);
    int last_id = -1;  // runs are long: most nodes are of the same kind as the one before
    std::uint16_t appearance = 0;
    for (std::size_t i = 0; i < kBlockNodes; ++i) {
        if (block.ids[i] != last_id) {
            last_id = block.ids[i];
            appearance = appearance_of_entry[entry_of(block.ids[i], block.names)];
        }
        // The game's z counts northwards: layers of 256 nodes are in reverse order.
        const std::size_t layer = 15 - i / 256;
        out->cells[layer * 256 + i % 256] = appearance;
    }
    const auto is_air = [&](std::uint16_t cell) {
        return out->appearances[cell].material == voxel::Material::kAir;
    };
    if (std::all_of(out->cells.begin(), out->cells.end(), is_air))
        return nullptr;
    const auto is_first = [&](std::uint16_t cell) { return cell == out->cells.front(); };
    if (std::all_of(out->cells.begin(), out->cells.end(), is_first)) {
        out->appearances = {out->appearances[out->cells.front()]};
        out->cells = {};
    }
    return out;
}

}  // namespace terravox::luanti
