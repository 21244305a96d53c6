#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace terravox::sunlight {

/// What is seen of a cell from above.
enum class Kind : std::uint8_t {
    kUnknown,  ///< nothing is known of it
    kGround,
    kRoof,
    kPlant,  ///< a crown or another object that hides the ground
    kWater,
};
inline constexpr std::size_t kKinds = 5;

/// What classes and echoes of points say of the material on top of a cell.
enum class Cover : std::uint8_t {
    kUnknown,
    kAsphalt,  ///< a road, or open ground that returns little light
    kVegetation,
    kOther,
};

/// Red, green and blue in linear light, 1 = the maximum of sRGB.
using Light = std::array<float, 3>;

/// A surface seen from above, in square cells; index = z * width + x, x to the east, z to the
/// south. The inner cells, at least `margin` away from all edges, are those that count; the margin
/// is for what casts shadows on them.
struct Surface {
    int width = 0;
    int height = 0;
    int margin = 0;
    double cell_m = 1;
    /// Of the highest that is seen, above any level; NaN = not known.
    std::vector<float> top_m;
    std::vector<Kind> kind;

    Surface() = default;
    /// Of which nothing is known.
    Surface(int given_width, int given_height, int given_margin, double given_cell_m);
    [[nodiscard]] std::size_t index(int x, int z) const noexcept {
        return static_cast<std::size_t>(z) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }
    [[nodiscard]] std::size_t size() const noexcept { return top_m.size(); }
};

/// A surface and its photograph, which covers inner cells only.
struct Scene : Surface {
    std::vector<Light> photo;         ///< of all cells; valid where `shown`
    std::vector<std::uint8_t> shown;  ///< 1 = the photograph shows the cell
    std::vector<Cover> cover;         ///< of all cells; empty: nothing is known

    Scene() = default;
    Scene(int given_width, int given_height, int given_margin, double given_cell_m);
    /// Not photographed yet.
    explicit Scene(Surface surface);
};

/// Fills unknown heights from those at most `reach` cells away; what is farther becomes very low.
/// Kinds are taken over kSmallGap cells only.
inline constexpr int kGapReach = 24;
inline constexpr int kSmallGap = 2;  ///< gaps up to here are chance
void fill_gaps(Surface& surface, int reach = kGapReach);

/// The inner cells, and `margin` cells around them.
/// @param margin of the result: at most that of the surface
[[nodiscard]] Surface inner_cells(const Surface& surface, int margin = 0);

/// The same surface in cells of twice the size: the highest top, the mean of the photograph, the
/// cover where those that are known agree.
[[nodiscard]] Scene halved(const Scene& scene);

/// Rise over run to the east and to the south; 0 across the edge of an object, where heights are
/// not those of one surface.
struct Slope {
    float east = 0;
    float south = 0;
    /// The upward part of the normal: (0, 1].
    [[nodiscard]] float up() const noexcept {
        return 1 / std::sqrt(1 + east * east + south * south);
    }
};
/// @return valid for inner cells that are not at an edge of the surface
[[nodiscard]] std::vector<Slope> measure_slopes(const Surface& surface);

/// Relative luminance of linear sRGB. Ref: IEC 61966-2-1.
[[nodiscard]] constexpr float luminance(const Light& light) noexcept {
    return 0.2126F * light[0] + 0.7152F * light[1] + 0.0722F * light[2];
}

}  // namespace terravox::sunlight
