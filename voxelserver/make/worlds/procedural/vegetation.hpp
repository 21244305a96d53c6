#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/voxel/box.hpp"
#include "voxelserver/make/worlds/procedural/surface.hpp"

namespace terravox::procedural {

enum class TreeKind : std::uint8_t { kOak, kBirch, kConifer, kPalm, kAcacia, kCactus, kBush };

/// One plant that stands on a column.
struct Tree {
    std::int32_t x = 0, z = 0;  ///< its column, level 0
    std::int32_t base = 0;      ///< y of its lowest voxel
    TreeKind kind = TreeKind::kOak;
    std::uint64_t hash = 0;  ///< of its place: determines size and details
    voxel::VoxelAttr trunk;
    voxel::VoxelAttr leaves;
};

/// A stretch of one column, half-open; y above the tree's base.
struct TreeRun {
    std::int32_t y0 = 0;
    std::int32_t y1 = 0;
    bool trunk = false;
};
struct TreeRuns {
    std::array<TreeRun, 12> runs;
    int count = 0;
};

inline constexpr int kTreeReach = 4;    ///< columns that a crown reaches from its trunk, at most
inline constexpr int kTreeHeight = 18;  ///< maximum height of a plant

/// Columns that this plant reaches from its trunk.
[[nodiscard]] int tree_reach(const Tree& tree) noexcept;
/// The parts of a plant in one column.
/// @param dx, dz from its trunk
[[nodiscard]] TreeRuns tree_runs(const Tree& tree, int dx, int dz) noexcept;

/// Which plants stand where. Each cell of a grid of columns holds at most one plant, anywhere in
/// it, so that the plants reaching into a box follow from the cells about it, whichever box is made
/// first. Immutable, thread-safe.
class Vegetation {
public:
    explicit Vegetation(const Terrain& terrain);

    static constexpr int kCell = 5;  ///< columns

    /// Nothing grows on higher ground, voxels: it is too cold there.
    [[nodiscard]] static double highest_ground(const Settings& s) noexcept {
        return s.water_level + kHighest * s.world_height;
    }

    /// The column in a cell where a plant may stand.
    struct Spot {
        std::int32_t x = 0;
        std::int32_t z = 0;
        std::uint64_t hash = 0;
    };
    [[nodiscard]] Spot spot(std::int32_t cell_x, std::int32_t cell_z) const noexcept;
    /// Whether any plant can stand there, independent of the terrain: cheap.
    [[nodiscard]] bool possible(const Spot& spot) const noexcept {
        return m_on && unit_of_chance(spot) < kDensest;
    }

    /// The plant that stands there.
    /// @param place, skin of its column
    [[nodiscard]] std::optional<Tree> tree(const Spot& spot, const Place& place,
                                           const Skin& skin) const noexcept;

    /// The crown that covers a place as seen from far above, by the climate of that place alone.
    /// @param x, z columns of level 0
    [[nodiscard]] std::optional<voxel::VoxelAttr> canopy(std::int32_t x, std::int32_t z,
                                                         const Place& place,
                                                         const Skin& skin) const noexcept;

    /// The small plant on a column of ground where no tree stands: a tuft, a flower.
    [[nodiscard]] std::optional<voxel::VoxelAttr> tuft(const Place& place,
                                                       const Skin& skin) const noexcept;

private:
    static constexpr double kDensest = 0.8;
    static constexpr double kHighest = 1.1;
    [[nodiscard]] static double unit_of_chance(const Spot& spot) noexcept {
        return static_cast<double>(spot.hash >> 52) * 0x1p-12;
    }
    /// How likely a cell is to hold a plant, and of which kind.
    struct Growth {
        double density = 0;
        TreeKind kind = TreeKind::kOak;
    };
    [[nodiscard]] Growth growth(const Spot& spot, const Place& place,
                                const Skin& skin) const noexcept;
    [[nodiscard]] Tree dressed(const Spot& spot, TreeKind kind, const Place& place) const noexcept;

    bool m_on;
    std::uint64_t m_cell_seed;
    std::uint64_t m_grove_seed;
    double m_water;
    double m_world;
};

}  // namespace terravox::procedural
