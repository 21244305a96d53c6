#include "voxelserver/worlds/luanti/node_block.hpp"

#include <algorithm>
#include <string>

#include "common/util/error.hpp"

namespace terravox::luanti {
namespace {

using voxel::VoxelAttr;

/// Index of a look in the list, to which it is added when it is new: names with the same look share
/// one.
std::uint16_t index_of(const VoxelAttr& look, std::vector<VoxelAttr>& looks) {
    const auto found = std::find(looks.begin(), looks.end(), look);
    const auto index = static_cast<std::uint16_t>(found - looks.begin());
    if (found == looks.end())
        looks.push_back(look);
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

std::shared_ptr<const NodeBlock> node_block_of(const MapBlock& block, NodeLooks& looks) {
    auto out = std::make_shared<NodeBlock>();
    std::vector<std::uint16_t> look_of_entry;
    look_of_entry.reserve(block.names.size());
    for (const MapBlock::Name& entry : block.names)
        look_of_entry.push_back(index_of(looks.of(entry.name), out->looks));
    out->cells.resize(kBlockNodes);
    int last_id = -1;  // runs are long: most nodes are of the same kind as the one before
    std::uint16_t look = 0;
    for (std::size_t i = 0; i < kBlockNodes; ++i) {
        if (block.ids[i] != last_id) {
            last_id = block.ids[i];
            look = look_of_entry[entry_of(block.ids[i], block.names)];
        }
        // The game's z counts northwards: layers of 256 nodes are in reverse order.
        const std::size_t layer = 15 - i / 256;
        out->cells[layer * 256 + i % 256] = look;
    }
    const auto is_air = [&](std::uint16_t cell) {
        return out->looks[cell].material == voxel::Material::kAir;
    };
    if (std::all_of(out->cells.begin(), out->cells.end(), is_air))
        return nullptr;
    const auto is_first = [&](std::uint16_t cell) { return cell == out->cells.front(); };
    if (std::all_of(out->cells.begin(), out->cells.end(), is_first)) {
        out->looks = {out->looks[out->cells.front()]};
        out->cells = {};
    }
    return out;
}

}  // namespace terravox::luanti
