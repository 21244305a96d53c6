#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "common/voxel/box.hpp"

namespace terravox::voxel {

/// One column of a box as bits, y in [0, 256), with the voxel just below (y = -1) and just above (y = 256).
class ColumnBits {
public:
    /// Sets [y0, y1); parts outside [-1, 257) are cut off.
    void fill(int y0, int y1) noexcept;
    [[nodiscard]] bool at(int y) const noexcept;  ///< y in [-1, 257)
    [[nodiscard]] std::uint64_t word(int i) const noexcept { return m_words[static_cast<std::size_t>(i)]; }
    [[nodiscard]] std::uint64_t word_from_above(int i) const noexcept;  ///< bit y = the voxel at y + 1
    [[nodiscard]] std::uint64_t word_from_below(int i) const noexcept;  ///< bit y = the voxel at y - 1

private:
    std::array<std::uint64_t, 4> m_words{};
    bool m_below = false, m_above = false;
};

/// Builds a box from columns with a margin of one voxel on every side, so that hidden faces are known across box edges.
///
/// Opaque voxels whose six neighbours are opaque become plain rock; all others ask `attr_at` for their attributes.
class BoxBuilder {
public:
    BoxBuilder() : m_solid(kSide * kSide), m_opaque(kSide * kSide) {}

    /// x, z in [-1, 65): marks [y0, y1) (local y) as solid. Opaque unless see_through(material).
    void add(int x, int z, int y0, int y1, bool opaque) noexcept;

    using AttrAt = std::function<VoxelAttr(int x, int y, int z)>;
    /// @param attr_at called once for each voxel that can be seen (local coordinates)
    /// @return nullptr when the box holds nothing solid
    [[nodiscard]] std::shared_ptr<const Box> build(const BoxKey& key, const AttrAt& attr_at) const;

private:
    static constexpr int kSide = kBoxSizeX + 2;
    static std::size_t index(int x, int z) noexcept { return static_cast<std::size_t>((z + 1) * kSide + x + 1); }
    /// Of column (x, z): voxels that need attributes, one word of 64.
    [[nodiscard]] std::uint64_t detail_word(int x, int z, int word) const noexcept;
    std::vector<ColumnBits> m_solid, m_opaque;
};

}  // namespace terravox::voxel
