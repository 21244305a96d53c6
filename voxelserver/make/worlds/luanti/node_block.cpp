#include "voxelserver/make/worlds/luanti/node_block.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "common/voxel/box_builder.hpp"

namespace terravox::luanti {
namespace {

// A game has some thousands of nodes; a file of made-up names must not fill the memory.
constexpr std::size_t kMaxAppearances = std::size_t{1} << 16;

}  // namespace

voxel::VoxelAttr NodeAppearances::of(std::string_view name) {
    {
        const std::shared_lock lock(m_appearances_mutex);
        if (const auto found = m_appearances.find(name); found != m_appearances.end())
            return found->second;
    }
    const minecraft::BlockAppearance appearance = m_table.of_full_name(name);
    if (!appearance.known)
        m_unknown.add(name);
    const voxel::VoxelAttr out = appearance.to_attr();
    const std::unique_lock lock(m_appearances_mutex);
    if (m_appearances.size() < kMaxAppearances)
        m_appearances.emplace(name, out);
    return out;
}

namespace {

using voxel::VoxelAttr;

/// Index of an appearance in the list, to which it is added when it is new: names with the same one
/// share one.
std::uint16_t compute_index(const VoxelAttr& appearance, std::vector<VoxelAttr>& appearances) {
    const auto found = std::find(appearances.begin(), appearances.end(), appearance);
    const auto index = static_cast<std::uint16_t>(found - appearances.begin());
    if (found == appearances.end())
        appearances.push_back(appearance);
    return index;
}

/// The entry of the names for an id.
std::size_t make_entry(std::uint16_t id, const std::vector<MapBlock::Name>& names) {
    const auto found =
        std::lower_bound(names.begin(), names.end(), id,
                         [](const MapBlock::Name& a, std::uint16_t b) { return a.id < b; });
    if (found == names.end() || found->id != id)
        throw util::Error("node id {} has no name", id);
    return static_cast<std::size_t>(found - names.begin());
}

}  // namespace

std::shared_ptr<const NodeBlock> make_node_block(const MapBlock& block,
                                                 NodeAppearances& appearances) {
    auto out = std::make_shared<NodeBlock>();
    std::vector<std::uint16_t> appearance_of_entry;
    appearance_of_entry.reserve(block.names.size());
    for (const MapBlock::Name& entry : block.names)
        appearance_of_entry.push_back(compute_index(appearances.of(entry.name), out->appearances));
    out->cells.resize(kBlockNodes);
    int last_id = -1;  // runs are long: most nodes are of the same kind as the one before
    std::uint16_t appearance = 0;
    for (std::size_t i = 0; i < kBlockNodes; ++i) {
        if (block.ids[i] != last_id) {
            last_id = block.ids[i];
            appearance = appearance_of_entry[make_entry(block.ids[i], block.names)];
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

namespace {

enum class Kind : std::uint8_t { kAir, kOpaque, kClear };

// Coordinates in the box, including its margin of one voxel.
const voxel::VoxelAttr* attr_at(const BoxBlocks& blocks, int x, int y, int z) noexcept {
    const NodeBlock* const block = blocks.at(x >> 4, y >> 4, z >> 4).get();
    return block == nullptr ? nullptr : &block->at(x & 15, y & 15, z & 15);
}

Kind kind_at(const BoxBlocks& blocks, int x, int y, int z) noexcept {
    const voxel::VoxelAttr* const attr = attr_at(blocks, x, y, z);
    if (attr == nullptr || attr->material == voxel::Material::kAir)
        return Kind::kAir;
    return voxel::see_through(attr->material) ? Kind::kClear : Kind::kOpaque;
}

// Adds the runs of voxels of one kind. Around the box only opaque voxels count: they hide what is
// inside.
void add_column(const BoxBlocks& blocks, int x, int z, voxel::BoxBuilder& builder) {
    constexpr int kEnd = voxel::kBoxSizeY + 1;
    const bool is_inside = x >= 0 && x < voxel::kBoxSizeX && z >= 0 && z < voxel::kBoxSizeZ;
    Kind kind = Kind::kAir;
    int begin = -1;
    for (int y = -1; y <= kEnd; ++y) {
        const Kind next = y < kEnd ? kind_at(blocks, x, y, z) : Kind::kAir;
        if (next == kind)
            continue;
        if (kind == Kind::kOpaque || (kind == Kind::kClear && is_inside))
            builder.add(x, z, begin, y, kind == Kind::kOpaque);
        kind = next;
        begin = y;
    }
}

}  // namespace

std::shared_ptr<const voxel::Box> to_box(const BoxBlocks& blocks, const voxel::BoxKey& key) {
    voxel::BoxBuilder builder;
    for (int z = -1; z <= voxel::kBoxSizeZ; ++z) {
        for (int x = -1; x <= voxel::kBoxSizeX; ++x)
            add_column(blocks, x, z, builder);
    }
    return builder.build(key, [&](int x, int y, int z) { return *attr_at(blocks, x, y, z); });
}

}  // namespace terravox::luanti
