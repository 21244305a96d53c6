#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "voxelserver/data/grid/patch.hpp"

namespace terravox::voxelize {

/// A single return of the ground, from the sample of a file.
struct GroundEcho {
    double x = 0;  ///< voxels of the world, continuous
    double z = 0;
    std::uint16_t intensity = 0;  ///< above 0
    std::uint16_t line = 0;       ///< number of the flight line
};

/// What the intensities of one file mean. Receivers, their settings and heights of flight differ
/// from line to line; brightness is relative to bright ground (dry grass, meadows, light soil) as
/// the same line sees it. Immutable, thread-safe.
class BrightnessScale {
public:
    static constexpr std::uint8_t kUnknown = 0;
    static constexpr double kBrightGround = 100;  ///< brightness of bright ground

    /// A flight line and the intensity of its bright ground.
    struct Line {
        std::uint16_t number = 0;
        double bright_ground = 0;
        friend bool operator==(const Line&, const Line&) = default;
    };

    BrightnessScale() = default;
    /// @param lines by number
    explicit BrightnessScale(std::vector<Line> lines) : m_lines(std::move(lines)) {}

    /// @return kUnknown for an intensity of 0 and for a line that the samples do not show
    [[nodiscard]] std::uint8_t brightness(std::uint16_t intensity,
                                          std::uint16_t line) const noexcept;
    [[nodiscard]] bool is_known() const noexcept { return !m_lines.empty(); }

    /// By number; empty = nothing is known.
    [[nodiscard]] const std::vector<Line>& lines() const noexcept { return m_lines; }
    friend bool operator==(const BrightnessScale&, const BrightnessScale&) = default;

private:
    std::vector<Line> m_lines;
};

/// The scale of some echoes. Lines are compared where they see the same ground, in cells of 64 m;
/// bright ground is the 80th percentile of all echoes, brought to one line. Lines that share no
/// ground with the others have a percentile of their own. Nothing is known from fewer than 64
/// echoes, from more than 256 lines, or where intensities hardly differ. The order of the echoes
/// does not matter.
[[nodiscard]] BrightnessScale scale_from(std::vector<GroundEcho> echoes, double voxel_m);

/// Files this near each other share echoes.
inline constexpr double kSharedScale_m = 500;

/// The files whose echoes have a part in the scale of one file: its own, and those of the files
/// within kSharedScale_m, so that neighbours agree about the ground along their border.
/// @param bounds of each file
[[nodiscard]] std::vector<std::size_t> files_sharing_scale(std::size_t file,
                                                           std::span<const grid::ColumnRect> bounds,
                                                           double voxel_m);

}  // namespace terravox::voxelize
