#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "common/voxel/world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"

namespace terravox::procedural {

/// Slowly changing properties of a place, which determine how hills and mountains are composed.
/// All about [-1, 1] unless stated.
struct Region {
    /// Height of the bare continent above the sea (below: negative), share of the world's height.
    double land = 0;
    double inland = 0;     ///< [0, 1]: 0 in the sea
    double mountains = 0;  ///< [0, 1]
    double hills = 0;      ///< height of the hills, share of the world's height
    double river = 1;  ///< [-1, 1]: 0 in the middle of a river, +-1 away from any on its two sides
    double temperature = 0;  ///< at sea level, about [0, 1]
    double moisture = 0;     ///< about [0, 1]
    /// Columns by which ridges and hills are displaced, so that none is straight.
    double warp_x = 0;
    double warp_z = 0;
};

/// Heights and climates of all places. A pure function of the settings; immutable, thread-safe.
/// Ref: ridges: Musgrave in Ebert et al., "Texturing and Modeling", 3rd edition, 2003, chapter 16
/// (ridged multifractal); moved coordinates: Quilez, "Domain warping", 2002.
class Terrain {
public:
    explicit Terrain(const Settings& settings);

    /// Coordinates are columns of the world; the middle of column i is i + 0.5.
    [[nodiscard]] Region region(double x, double z) const noexcept;

    /// Two heights of one place, voxels.
    struct Heights {
        double full = 0;    ///< with all octaves
        double smooth = 0;  ///< without those that are finer than two coarse voxels
    };
    /// @param region of that place
    /// @param voxel edge of the voxels to be made; 1: both heights are the same
    [[nodiscard]] Heights heights(const Region& region, double x, double z,
                                  double voxel) const noexcept;

    [[nodiscard]] const Settings& settings() const noexcept { return m_settings; }
    /// Bounds of the ground's height, voxels.
    [[nodiscard]] double highest() const noexcept {
        return m_settings.water_level + m_settings.world_height * kMax;
    }
    [[nodiscard]] double lowest() const noexcept {
        return m_settings.water_level - m_settings.world_height * kMin - 8;
    }

    /// Approximate height of the highest ground in the columns [-half, half) about the origin.
    [[nodiscard]] double highest_about_origin(double half) const noexcept;

private:
    static constexpr double kMax = 1.5;
    static constexpr double kMin = 0.75;
    [[nodiscard]] double hills(double x, double z, double voxel, double& smooth) const noexcept;
    [[nodiscard]] double ridges(double x, double z, double voxel, double& smooth) const noexcept;
    void find_origin();
    [[nodiscard]] double beauty() const noexcept;

    Settings m_settings;
    std::uint64_t m_seeds[16]{};
    double m_origin_x = 0, m_origin_z = 0;  ///< place of the world's origin in the noise
};

/// 0 below a, 1 above b, smooth between.
[[nodiscard]] inline double smooth_step(double a, double b, double v) noexcept {
    double t = (v - a) / (b - a);
    t = t < 0 ? 0 : t > 1 ? 1 : t;
    return t * t * (3 - 2 * t);
}
[[nodiscard]] inline double mixed(double a, double b, double share) noexcept {
    return a + (b - a) * share;
}

/// Slowly changing values, computed at the nodes of a lattice whose position does not depend on the
/// caller, and interpolated bilinearly: some twenty times as fast.
class RegionLattice {
public:
    /// Covers the columns [x0, x0 + side) x [z0, z0 + side).
    /// @param step columns between nodes
    RegionLattice(const Terrain& terrain, std::int32_t x0, std::int32_t z0, std::int32_t side,
                  std::int32_t step)
        : m_step(step),
          m_first_x(voxel::floor_div(x0, step)),
          m_first_z(voxel::floor_div(z0, step)),
          m_nodes_across(side / step + 3) {
        m_nodes.reserve(static_cast<std::size_t>(m_nodes_across) *
                        static_cast<std::size_t>(m_nodes_across));
        for (std::int32_t z = 0; z < m_nodes_across; ++z)
            for (std::int32_t x = 0; x < m_nodes_across; ++x)
                m_nodes.push_back(
                    terrain.region((m_first_x + x) * static_cast<double>(step) + 0.5,
                                   (m_first_z + z) * static_cast<double>(step) + 0.5));
    }

    /// The values at a column.
    [[nodiscard]] Region at(std::int32_t x, std::int32_t z) const noexcept {
        const std::int32_t in_x = x - m_first_x * m_step;
        const std::int32_t in_z = z - m_first_z * m_step;
        const double fx = static_cast<double>(in_x % m_step) / m_step;
        const double fz = static_cast<double>(in_z % m_step) / m_step;
        const Region* a =
            &m_nodes[static_cast<std::size_t>(in_z / m_step * m_nodes_across + in_x / m_step)];
        const Region *b = a + 1, *c = a + m_nodes_across, *d = c + 1;
        const double wa = (1 - fx) * (1 - fz);
        const double wb = fx * (1 - fz);
        const double wc = (1 - fx) * fz;
        const double wd = fx * fz;
        Region out;
        for (const auto field :
             {&Region::land, &Region::inland, &Region::mountains, &Region::hills, &Region::river,
              &Region::temperature, &Region::moisture, &Region::warp_x, &Region::warp_z})
            out.*field = wa * a->*field + wb * b->*field + wc * c->*field + wd * d->*field;
        return out;
    }

private:
    std::int32_t m_step;
    std::int32_t m_first_x;
    std::int32_t m_first_z;
    std::int32_t m_nodes_across;
    std::vector<Region> m_nodes;
};

}  // namespace terravox::procedural
