#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "common/voxel/box.hpp"
#include "voxelserver/make/worlds/procedural/vegetation.hpp"

namespace terravox::procedural {

/// One column of voxels of a level; y in voxels of that level.
struct Column {
    std::int32_t top = 0;    ///< one past the highest voxel of ground
    std::int32_t water = 0;  ///< one past the highest of water; top where it is dry
    voxel::Material material = voxel::Material::kRock;
    voxel::Material under = voxel::Material::kRock;
    std::uint8_t under_depth = 0;
    bool ice = false, snow = false;  ///< on the water; snow lies on ice
    bool wooded = false;             ///< the ground's topmost voxel is a crown, of `colour`
    voxel::Rgb8 colour;
    voxel::Rgb8 under_colour;
    float temperature = 0, moisture = 0;  ///< for the colour of rock
    std::int32_t first_run = -1;          ///< of what stands on it
};

/// The columns of one stack of boxes with a margin of one, from which its boxes are made. A pure
/// function of terrain and key.
class Columns {
public:
    static constexpr int kMargin = 1;
    static constexpr int kSide = voxel::kBoxSizeX + 2 * kMargin;

    /// @param x, z in [-1, 65)
    [[nodiscard]] const Column& at(int x, int z) const noexcept { return m_columns[index(x, z)]; }
    [[nodiscard]] int level() const noexcept { return m_level; }
    [[nodiscard]] std::size_t memory_bytes() const noexcept {
        return sizeof(*this) + m_columns.capacity() * sizeof(Column) +
               m_runs.capacity() * sizeof(Run);
    }
    /// One past the highest voxel of all.
    [[nodiscard]] std::int32_t highest() const noexcept { return m_highest; }

    /// A stretch of a plant in a column, half-open.
    struct Run {
        std::int32_t y0 = 0;
        std::int32_t y1 = 0;
        std::int32_t next = -1;
        bool trunk = false;
        voxel::VoxelAttr attr;
    };
    [[nodiscard]] const std::vector<Run>& runs() const noexcept { return m_runs; }
    /// The attributes of a voxel that one of the columns holds. Where plants overlap: the trunk,
    /// else the plant that was placed last.
    [[nodiscard]] voxel::VoxelAttr attr(int x, std::int32_t y, int z) const noexcept;

private:
    friend class ColumnMaker;
    /// Colour of the rock in a voxel: its layers are bent.
    [[nodiscard]] voxel::Rgb8 rock_colour(const Column& column, int x, std::int32_t y,
                                          int z) const noexcept;
    static std::size_t index(int x, int z) noexcept {
        return static_cast<std::size_t>((z + kMargin) * kSide + x + kMargin);
    }
    void add_run(int x, int z, std::int32_t y0, std::int32_t y1, bool trunk,
                 const voxel::VoxelAttr& attr);

    int m_level = 0;
    std::int32_t m_x0 = 0, m_z0 = 0;  ///< its first column, voxels of the level
    std::uint64_t m_rock_seed = 0;
    std::int32_t m_highest = std::numeric_limits<std::int32_t>::min();
    std::vector<Column> m_columns;
    std::vector<Run> m_runs;
};

/// Makes Columns. Immutable, thread-safe.
///
/// Level 0: heights of every column; slowly changing values are computed on a lattice of four
/// columns and interpolated bilinearly. The ground under a plant decides whether it stands there.
/// Coarser levels are made independently, each coarse voxel from its middle column: heights without
/// the octaves that are finer than it, surfaces by the full ones, so that rock, sand and snow keep
/// their shares. Plants of levels 1 and 2 are those of level 0, as the key columns of the
/// downsampler see them; above, a column is a crown's where its middle lies under one.
class ColumnMaker {
public:
    explicit ColumnMaker(const Settings& settings);
    [[nodiscard]] Columns make(int level, std::int32_t bx, std::int32_t bz) const;
    [[nodiscard]] const Terrain& terrain() const noexcept { return m_terrain; }

    static constexpr int kPlantLevels = 3;  ///< levels with every plant in its place

private:
    class FineHeights;
    class CoarseRegions;
    [[nodiscard]] Columns empty(int level, std::int32_t bx, std::int32_t bz) const;
    [[nodiscard]] Columns make_fine(std::int32_t bx, std::int32_t bz) const;
    [[nodiscard]] Columns make_coarse(int level, std::int32_t bx, std::int32_t bz) const;
    void set_ground(Column& column, const Place& place, const Skin& skin, int level,
                    double smooth_height) const noexcept;
    void plant(Columns& out, const Tree& tree, std::int32_t x0, std::int32_t z0) const;
    void plant_coarse(Columns& out, const CoarseRegions& regions, std::int32_t x0,
                      std::int32_t z0) const;
    [[nodiscard]] Place place_at(const CoarseRegions& regions, const Region& region, std::int32_t x,
                                 std::int32_t z, double height) const noexcept;

    Terrain m_terrain;
    Surface m_surface;
    Vegetation m_vegetation;
};

}  // namespace terravox::procedural
