#pragma once

#include <cstddef>
#include <optional>
#include <stop_token>
#include <vector>

#include "raytracer/analyse/raster/cell_file.hpp"

namespace terravox::analyse {

/// A part of a band in memory, row by row from the north-west.
struct CellPatch {
    int width = 0;
    int height = 0;
    std::vector<float> values;

    [[nodiscard]] std::size_t index(int x, int y) const noexcept {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(x);
    }
    [[nodiscard]] float at(int x, int y) const noexcept { return values[index(x, y)]; }
};

/// Whether a height of the ground is measured or interpolated.
inline constexpr float kMeasuredGround = 1;
inline constexpr float kInterpolatedGround = 2;

/// Interpolates the ground where it is covered: the nearest known cell in each of eight directions,
/// up to `reach` cells away, weighted by the inverse square of its distance, and no higher than the
/// surface. Cells without a surface stay without ground. A cell's value depends on cells at most
/// `reach` away, so that a raster may be filled in parts that overlap.
/// @param source set to where each height comes from, or core::kNoData
void fill_ground(CellPatch& ground, const CellPatch& surface, int reach, CellPatch& source);

/// Rise of a surface, metres per metre.
struct Gradient {
    double east = 0;
    double north = 0;
};

/// Of the plane that fits the heights of a square window best (least squares). Heights of voxels
/// are in steps, which a plane through many of them evens out.
/// @param radius cells to each side of (x, y); those beyond the patch do not count
/// @return nullopt where (x, y) has no height, or fewer than three in no line
[[nodiscard]] std::optional<Gradient> gradient_at(const CellPatch& heights, int x, int y,
                                                  int radius, double edge_m);

[[nodiscard]] double slope_deg(Gradient gradient) noexcept;
/// Direction in which water flows, clockwise from north, [0, 360).
/// @return nullopt on level ground, which has none
[[nodiscard]] std::optional<double> aspect_deg(Gradient gradient) noexcept;

/// Light from a direction on a matt surface: 1 (in its own shadow) to 255.
/// Ref: Horn, "Hill shading and the reflectance map", 1981.
[[nodiscard]] float hillshade(Gradient gradient, double azimuth_deg, double altitude_deg) noexcept;

/// The surface whose slope, aspect and hillshade are wanted.
enum class ReliefOf : bool { kGround, kSurface };

struct ReliefOptions {
    ReliefOf of = ReliefOf::kGround;
    int window = 5;       ///< edge of the window of slopes, cells: odd
    double fill_m = 100;  ///< how far the ground is interpolated below buildings; 0: not at all
    double light_azimuth_deg = 315;
    double light_altitude_deg = 45;
};

/// Computes the terrain's bands that depend on neighbours: the ground below buildings, heights
/// above it, slope, aspect, hillshade. Block by block, each with the cells around that it needs.
/// @param edge_m of a cell
/// @throws Error "interrupted" when stopped, and as CellFile
void derive_terrain(CellFile& cells, double edge_m, const ReliefOptions& options,
                    const std::stop_token& stop);

}  // namespace terravox::analyse
