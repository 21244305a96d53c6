#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "voxelserver/data/sunlight/flight_light.hpp"
#include "voxelserver/data/sunlight/sun.hpp"

namespace terravox::sunlight {

/// What a cell tells those around it.
struct BrightCell {
    enum class As : std::uint8_t { kNothing, kLit, kShadow };
    float light = 0;  ///< luminance; of what lies in the sun, as it would be on flat ground
    As as = As::kNothing;
};

/// Sums over the square of cells around each cell, made for all of them together: windows of 1, 2,
/// 4, 8 cells are combined, along rows and then along columns.
class BrightnessAround {
public:
    struct Sums {
        float lit = 0;
        float brightest_lit = 0;
        float lit_count = 0;
        float shadow = 0;
        float shadow_count = 0;
    };

    /// @param width of a row
    /// @param reach of a square: so many cells to each side
    /// @param cells row by row; those that say nothing do not count
    BrightnessAround(int width, int reach, const std::vector<BrightCell>& cells);

    /// @param x,z at least `reach` cells from the edges
    [[nodiscard]] Sums at(int x, int z) const noexcept;

private:
    using Plane = std::vector<float>;  ///< by the first cell of a square
    template <class Combine>
    [[nodiscard]] Plane over_squares(const Plane& values, const Combine& combine) const;

    std::size_t m_width;
    std::size_t m_reach;
    Plane m_lit;
    Plane m_brightest_lit;
    Plane m_lit_count;
    Plane m_shadow;
    Plane m_shadow_count;
};

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
    [[nodiscard]] Light make_light(std::size_t i, float sun) const noexcept;
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

/// Inner cells next to the margin that get no albedo, as not all around them is known.
inline constexpr int kEdgeReach = kMaxCompareReach + kSurfaceEdge;

/// The photograph without sun, shadow and sky: albedo, linear, not yet clamped.
///
/// Where the surface says lit or in shadow, the light follows from it. Near the edges of shadows,
/// where surface and photograph differ by up to a metre, the photograph decides: a cell receives
/// as much light as gives it an albedo that occurs around it.
/// @param surface without gaps (fill_gaps)
/// @param inner inner_cells() of the surface, photographed
/// @param light over the cells that get an albedo
/// @return of `inner`; valid for those that are shown and at least kEdgeReach away from its edges
[[nodiscard]] std::vector<Light> remove_light(const Surface& surface, const Scene& inner,
                                              const LightField& light);

}  // namespace terravox::sunlight
