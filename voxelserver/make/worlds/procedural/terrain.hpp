#pragma once

#include <cstdint>

#include "voxelserver/make/worlds/kind/procedural_settings.hpp"

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

}  // namespace terravox::procedural
