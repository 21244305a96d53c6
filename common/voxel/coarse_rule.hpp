#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "common/voxel/box.hpp"

namespace terravox::voxel {

[[nodiscard]] constexpr Grain to_grain(Material material) noexcept;

/// Up to this level (voxels of 4 m where the finest have 1 m) no part of a shell is lost; above it
/// shells keep their area instead.
inline constexpr int kShellsKeptTo = 2;

/// The downsampling rule: derives eight coarse voxels from one fine brick.
///
/// Of the eight children of a coarse voxel (2 x 2 columns of two; the "key column" is the
/// north-western one), the first of these that applies:
/// 1. Opaque when a child is terrain whose lower neighbour among the eight is not opaque (an
///    overhang: a sheet, not a hill). Also up to level 2: when a child is shell, an object stands
///    in the key column, or two children are objects; from level 3 on: when shells or objects stand
///    in the key column, or in all three others.
/// 2. Where at least four are opaque or water: the one that tops more columns, on a tie that of the
///    key column (else opaque).
/// 3. Leaves or wires, when they stand in the key column, or in all three others.
/// 4. Air.
///
/// Rationale, and properties that the tests verify:
/// - No light leaks. Up to level 2 the coarse opaque voxels cover all shells of the level below, so
///   what these closed stays closed from every side. At all levels, shells and objects close every
///   vertical line that they closed before, by the key column; terrain that is solid from a common
///   floor up (at least two voxels under water) closes it by the floor (step 2). No rule of eight
///   children closes jagged sheets of every material and leaves terrain unbiased: it would have to
///   keep a voxel for each child of at least one column, and ground would grow at every slope. So
///   terrain is closed when thick, flat, or without steps of two (overhangs are kept).
/// - Thin structures survive: sheets of anything (four of eight) at all levels; decks, walls and
///   strips one voxel wide, diagonal ones too, to level 2. Kept at all levels they would fill a
///   town: in a real one 28 % lies under roofs, and 67 % would at level 5; by this rule 52 %.
/// - Ground keeps its height: half full counts as full. Flat ground can only be rounded up, by at
///   most half a coarse voxel on average.
/// - Lakes stay flat and whole: a surface fills four or eight children, whatever its parity, and
///   shallow water wins over its bed. The shore keeps its place on average, since columns vote.
///   Brooks one voxel wide are interrupted. Where water wins, the rock below has no attributes.
/// - Leaves, wires and lone objects keep the area they cover, seen from above: one lone voxel of
///   four survives, four times as large. A forest keeps its gaps and a thin crown does not become a
///   block; any threshold on counts would fill one and lose the other. Wires fade on purpose:
///   preserved, they would become beams of 32 voxels at level 5.
/// - The appearance is that of the visible surface: the topmost child with attributes of each
///   column votes among the children that decided (in step 1, with fewer than four opaque ones,
///   without the terrain that did not decide); the most frequent material wins, the highest on a
///   tie; its colours are averaged.
///
/// Ref: Laine & Karras, "Efficient Sparse Voxel Octrees", 2010, and Crassin et al., "GigaVoxels",
/// 2009, average density instead, which needs partly transparent voxels.
struct CoarseVoxels {
    std::uint64_t solid = 0;  ///< which of the eight are solid: bits of kCorners
    std::uint64_t seen = 0;   ///< which of those have attributes; a subset of `solid`
    /// The fine voxels whose attributes count; a subset of the brick's detail.
    std::uint64_t sources = 0;
};

/// The lowest north-western child of each of the eight coarse voxels, as a bit of the fine brick;
/// the other children are at +1, +4, +5, +16, +17, +20, +21.
inline constexpr std::uint64_t kCorners = 0x0000'0505'0000'0505ULL;
inline constexpr std::uint64_t kEightChildren = 0x33'0033ULL;

/// @param brick   a fine brick
/// @param attrs   attributes of its `detail`, in bit order
/// @param level   level of the coarse voxels, >= 1
[[nodiscard]] CoarseVoxels coarse_voxels(const TreeCell& brick, std::span<const VoxelAttr> attrs,
                                         int level) noexcept;

/// The attributes of the coarse voxel whose lowest child is bit `corner`, one of `coarse.seen`.
[[nodiscard]] VoxelAttr coarse_attr(const TreeCell& brick, std::span<const VoxelAttr> attrs,
                                    const CoarseVoxels& coarse, int corner) noexcept;

/// Compacts bits of kCorners: corner (2 x, 2 y, 2 z) moves to (x, y, z), so that eight coarse
/// voxels fill their octant of a coarse brick.
[[nodiscard]] constexpr std::uint64_t gather_corners(std::uint64_t corners) noexcept {
    corners = (corners & 0x0000'0101'0000'0101ULL) |
              (corners & 0x0000'0404'0000'0404ULL) >> 1;  // x = 2 to 1
    corners = (corners & 0x0000'0003'0000'0003ULL) |
              (corners & 0x0000'0300'0000'0300ULL) >> 4;         // z = 2 to 1
    return (corners & 0xFFFF) | (corners >> 32 & 0xFFFF) << 16;  // y = 2 to 1
}

// Implementation. In the header, so that it is inlined into the loop over bricks (downsample.cpp).

namespace coarse_rule {

inline constexpr std::size_t kGrains = 5;
inline constexpr std::uint64_t kUpper = 0xFFFF'0000'FFFF'0000ULL;  // the upper child of each pair

// A lookup table, since it is read for every fine voxel: no branch.
inline constexpr std::array<Grain, 256> kGrainOf = [] {
    std::array<Grain, 256> grains{};
    grains.fill(Grain::kObject);  // also for numbers without a material
    for (const MaterialTraits& traits : kMaterialTraits)
        grains[static_cast<std::size_t>(traits.material)] = traits.grain;
    return grains;
}();

// The number of set children of the eight, for all corners at once, as binary digits.
// Ref: carry-save adders as in Warren, "Hacker's Delight", section 5-1.
struct Counts {
    std::uint64_t twos;
    std::uint64_t fours;
    std::uint64_t eights;
    [[nodiscard]] std::uint64_t two_or_more() const noexcept {
        return (twos | fours | eights) & kCorners;
    }
    [[nodiscard]] std::uint64_t four_or_more() const noexcept {
        return (fours | eights) & kCorners;
    }
};
inline Counts count_children(std::uint64_t m) noexcept {
    struct Sum {
        std::uint64_t digit;
        std::uint64_t carry;
    };
    const auto add = [](std::uint64_t a, std::uint64_t b, std::uint64_t c) {
        return Sum{a ^ b ^ c, (a & b) | ((a ^ b) & c)};
    };
    const Sum one = add(m, m >> 1, m >> 4);
    const Sum two = add(m >> 5, m >> 16, m >> 17);
    const Sum three = add(m >> 20, m >> 21, 0);
    const Sum ones = add(one.digit, two.digit, three.digit);
    const Sum low = add(one.carry, two.carry, three.carry);
    const Sum twos = add(low.digit, ones.carry, 0);
    return {twos.digit, low.carry ^ twos.carry, low.carry & twos.carry};
}

/// All children of the given corners.
inline std::uint64_t find_children(std::uint64_t corners) noexcept {
    return corners * kEightChildren;
}
/// The lower child of each column in which either child is set.
inline std::uint64_t find_columns(std::uint64_t voxels) noexcept {
    return (voxels | voxels >> 16) & ~kUpper;
}
/// Corners that have at least one child set.
inline std::uint64_t any_child(std::uint64_t voxels) noexcept {
    const std::uint64_t columns = find_columns(voxels);
    const std::uint64_t pairs = columns | columns >> 4;
    return (pairs | pairs >> 1) & kCorners;
}
/// Corners whose key column contains one of these voxels, or whose three other columns all do:
/// preserves the area seen from above.
inline std::uint64_t sampled(std::uint64_t voxels) noexcept {
    const std::uint64_t columns = find_columns(voxels);
    return (columns | (columns >> 1 & columns >> 4 & columns >> 5)) & kCorners;
}

// Step 2 where opaque children and water share a voxel: which of the two tops more columns.
inline std::uint64_t won_by_water(std::uint64_t shared, std::uint64_t opaque,
                                  std::uint64_t water) noexcept {
    constexpr std::uint64_t kColumns = kEightChildren & 0xFFFF;
    const std::uint64_t water_tops = find_columns(water & ~((opaque & kUpper) >> 16));
    const std::uint64_t opaque_tops = find_columns(opaque & ~((water & kUpper) >> 16));
    std::uint64_t won = 0;
    for (; shared != 0; shared &= shared - 1) {
        const int corner = std::countr_zero(shared);
        const int lead = std::popcount(water_tops >> corner & kColumns) -
                         std::popcount(opaque_tops >> corner & kColumns);
        if (lead > 0 || (lead == 0 && (water_tops >> corner & 1) != 0))
            won |= std::uint64_t{1} << corner;
    }
    return won;
}

}  // namespace coarse_rule

constexpr Grain to_grain(Material material) noexcept {
    return coarse_rule::kGrainOf[static_cast<std::size_t>(material)];
}

inline CoarseVoxels coarse_voxels(const TreeCell& brick, std::span<const VoxelAttr> attrs,
                                  int level) noexcept {
    using namespace coarse_rule;
    std::array<std::uint64_t, kGrains> grains{};
    std::size_t next = 0;
    for (std::uint64_t left = brick.detail; left != 0; left &= left - 1)
        grains[static_cast<std::size_t>(to_grain(attrs[next++].material))] |= left & (~left + 1);
    const auto of = [&](Grain grain) { return grains[static_cast<std::size_t>(grain)]; };
    const std::uint64_t shell = of(Grain::kShell);
    const std::uint64_t object = of(Grain::kObject);
    const std::uint64_t water = of(Grain::kWater);
    const std::uint64_t sparse = of(Grain::kSparse);
    const std::uint64_t terrain = of(Grain::kTerrain) | (brick.mask & ~brick.detail);
    const std::uint64_t opaque = terrain | shell | object;

    // Step 1: what must not be lost.
    const std::uint64_t overhang = terrain & kUpper & ~(opaque << 16);
    const std::uint64_t kept =
        any_child(overhang) |
        (level > kShellsKeptTo ? sampled(shell | object)
                               : any_child(shell) | count_children(object).two_or_more() |
                                     (find_columns(object) & kCorners));
    // Step 2: what fills at least half.
    const std::uint64_t half_full = count_children(opaque | water).four_or_more() & ~kept;
    const std::uint64_t wet = half_full & any_child(water);
    const std::uint64_t dry = any_child(opaque);
    const std::uint64_t coarse_water = (wet & ~dry) | won_by_water(wet & dry, opaque, water);
    const std::uint64_t coarse_opaque = kept | (half_full & ~coarse_water);
    // Step 3: what stands in the key column.
    const std::uint64_t coarse_sparse = sampled(sparse) & ~(coarse_opaque | coarse_water);

    const std::uint64_t full =
        find_children(coarse_opaque & ~(kept & ~count_children(opaque).four_or_more()));
    const std::uint64_t deciding =
        (opaque & full) | ((shell | object | overhang) & find_children(kept)) |
        (water & find_children(coarse_water)) | (sparse & find_children(coarse_sparse));
    const std::uint64_t shown = deciding & brick.detail;
    CoarseVoxels out;
    out.solid = coarse_opaque | coarse_water | coarse_sparse;
    out.sources = shown & ~((shown & kUpper) >> 16);
    out.seen = any_child(out.sources);
    return out;
}

inline VoxelAttr coarse_attr(const TreeCell& brick, std::span<const VoxelAttr> attrs,
                             const CoarseVoxels& coarse, int corner) noexcept {
    // The topmost voxel of each column, highest first, so that the highest wins a tie.
    std::array<const VoxelAttr*, 4> found{};
    std::size_t count = 0;
    const std::uint64_t own = coarse.sources & kEightChildren << corner;
    for (const std::uint64_t layer : {own & coarse_rule::kUpper, own & ~coarse_rule::kUpper})
        for (std::uint64_t left = layer; left != 0; left &= left - 1)
            found[count++] = &attrs[brick.compute_index(std::countr_zero(left)) - brick.first];
    std::size_t best = 0;
    int most_votes = 0;
    for (std::size_t i = 0; i < count; ++i) {
        int votes = 0;
        for (std::size_t k = 0; k < count; ++k)
            votes += found[k]->material == found[i]->material;
        if (votes > most_votes) {
            most_votes = votes;
            best = i;
        }
    }
    VoxelAttr out = *found[best];
    int sum[3] = {}, coloured = 0;
    for (std::size_t i = 0; i < count; ++i) {
        if (found[i]->material != out.material || !found[i]->has_colour())
            continue;
        sum[0] += found[i]->colour.r;
        sum[1] += found[i]->colour.g;
        sum[2] += found[i]->colour.b;
        ++coloured;
    }
    if (coloured > 0) {
        const auto mean = [&](int s) {
            return static_cast<std::uint8_t>((s + coloured / 2) / coloured);
        };
        out.colour = {mean(sum[0]), mean(sum[1]), mean(sum[2])};
        out.flags =
            static_cast<std::uint8_t>((out.flags & ~VoxelAttr::kTinted) | VoxelAttr::kHasColour);
    }
    return out;
}

}  // namespace terravox::voxel
