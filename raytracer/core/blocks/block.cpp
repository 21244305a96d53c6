#include "raytracer/core/blocks/block.hpp"

#include <algorithm>
#include <bit>
#include <span>
#include <utility>
#include <vector>

namespace terravox::blocks {
namespace {

using voxel::TreeCell;
using voxel::VoxelAttr;

constexpr std::size_t kBrickVoxels = 64;

/// The bricks of a box that are full of equal voxels, and what they are full of.
class EqualBricks {
public:
    explicit EqualBricks(const voxel::Box& box) : m_box(box) {
        for (const TreeCell& root : box.cells().first(voxel::Box::kRootCount))
            m_first_brick += static_cast<std::size_t>(std::popcount(root.detail));
        m_kind_of.assign(box.cells().size() - m_first_brick, kNone);
        for (std::size_t i = 0; i < m_kind_of.size(); ++i) {
            const auto attrs = list_attrs(i);
            const bool equal = attrs.size() == kBrickVoxels &&
                               std::ranges::all_of(attrs, [&](const VoxelAttr& attr) {
                                   return attr == attrs.front();
                               });
            if (equal && (m_kind_of[i] = kind(attrs.front())) != kNone)
                ++m_count;
        }
    }
    [[nodiscard]] std::size_t saved_bytes() const noexcept {
        return (m_count - m_kinds.size()) * kBrickVoxels * sizeof(VoxelAttr);
    }
    [[nodiscard]] Block shared() const {
        std::vector<TreeCell> cells(m_box.cells().begin(), m_box.cells().end());
        std::vector<VoxelAttr> attrs;
        attrs.reserve(m_box.attrs().size() - saved_bytes() / sizeof(VoxelAttr));
        for (const VoxelAttr& kind : m_kinds)
            attrs.insert(attrs.end(), kBrickVoxels, kind);
        const auto shared_attrs = static_cast<std::uint32_t>(attrs.size());
        for (std::size_t i = 0; i < m_kind_of.size(); ++i) {
            TreeCell& brick = cells[m_first_brick + i];
            if (m_kind_of[i] != kNone) {
                brick.first = static_cast<std::uint32_t>(m_kind_of[i] * kBrickVoxels);
                continue;
            }
            brick.first = static_cast<std::uint32_t>(attrs.size());
            const auto own = list_attrs(i);
            attrs.insert(attrs.end(), own.begin(), own.end());
        }
        return {voxel::Box::from_arrays(m_box.key(), cells, attrs), false, shared_attrs};
    }

private:
    static constexpr std::uint8_t kMaxKinds = 16;  // more are no deep water
    static constexpr std::uint8_t kNone = kMaxKinds;

    [[nodiscard]] std::span<const VoxelAttr> list_attrs(std::size_t brick) const noexcept {
        const TreeCell& cell = m_box.cells()[m_first_brick + brick];
        return m_box.attrs().subspan(cell.first,
                                     static_cast<std::size_t>(std::popcount(cell.detail)));
    }
    [[nodiscard]] std::uint8_t kind(const VoxelAttr& attr) {
        const auto found = std::ranges::find(m_kinds, attr);
        const auto out = static_cast<std::uint8_t>(found - m_kinds.begin());
        if (found == m_kinds.end() && out < kMaxKinds)
            m_kinds.push_back(attr);
        return out;
    }

    const voxel::Box& m_box;
    std::size_t m_first_brick = voxel::Box::kRootCount;
    std::vector<std::uint8_t> m_kind_of;  ///< by brick
    std::vector<VoxelAttr> m_kinds;
    std::size_t m_count = 0;
};

}  // namespace

Block packed(std::shared_ptr<const voxel::Box> box) {
    // Where the world keeps the box, a second one would take memory instead of saving it.
    if (box.use_count() == 1) {
        const EqualBricks equal(*box);
        if (equal.saved_bytes() >= box->memory_bytes() / 2)
            return equal.shared();
    }
    return {std::move(box)};
}

}  // namespace terravox::blocks
