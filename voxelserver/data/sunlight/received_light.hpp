#pragma once

#include <array>
#include <optional>
#include <vector>

#include "voxelserver/data/sunlight/brightness_around.hpp"
#include "voxelserver/data/sunlight/light_levels.hpp"
#include "voxelserver/data/sunlight/surface_light.hpp"

namespace terravox::sunlight {

/// How far from a cell its photograph is compared with that of others at most, cells.
inline constexpr int kMaxCompareReach = 6;

/// The sunlight that cells receive, by their surface and their photograph. Use one object per
/// thread.
class ReceivedLight {
public:
    /// @param scene without gaps (fill_gaps) and without a margin; all three must outlive this
    /// @param surface of these cells
    ReceivedLight(const Scene& scene, const SurfaceLight& surface, const FlightLight& light);

    /// Sunlight at a cell, over that on flat ground in the sun: [0, 2.5]. Where the surface is
    /// certain it is the surface's, but for cells that are too bright for that; near edges of
    /// shadows the photograph decides.
    /// @param x,z shown, and at least kMaxCompareReach + kSurfaceEdge cells from the edges
    [[nodiscard]] float sun_at(int x, int z) const;

private:
    [[nodiscard]] Light light_of(std::size_t i, float sun) const noexcept;
    [[nodiscard]] std::optional<float> lit_by_photo(int x, int z) const;
    [[nodiscard]] float min_sun(int x, int z) const;
    [[nodiscard]] float max_brightness(int x, int z, Kind kind) const;
    [[nodiscard]] const BrightnessAround& around(std::optional<Kind> kind, bool edges) const;
    [[nodiscard]] float brightness(std::size_t i) const noexcept;

    const Scene& m_scene;
    const SurfaceLight& m_surface;
    const FlightLight& m_light;
    int m_reach;  ///< cells that are compared: so many to each side
    float m_sky;
    float m_veil;
    std::vector<BrightCell> m_seen;
    /// By kind, of all kinds, and of all with the edges of shadows; made when they are needed.
    mutable std::array<std::optional<BrightnessAround>, kKinds + 2> m_around;
    std::vector<Light> m_root;         ///< square root of the photograph without its veil
    std::vector<Light> m_albedo_root;  ///< the same of the albedo, by the surface alone
};

}  // namespace terravox::sunlight
