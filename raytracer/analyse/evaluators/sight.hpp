#pragma once

#include <cstdint>
#include <span>

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/blocks/block_manager.hpp"
#include "raytracer/core/scene/scene.hpp"

namespace terravox::analyse {

/// A point on the grid of on_grid(), on which lines of sight begin and end: computed in two ways it
/// is the same.
[[nodiscard]] core::Vec3 on_sight_grid(core::Vec3 point) noexcept;

/// Square of the distance on the map.
[[nodiscard]] double horizontal_distance2(core::Vec3 a, core::Vec3 b) noexcept;

/// How strongly lines of sight sag in a world, whose heights are measured from a curved surface:
/// a line of length d lies up to d^2/4 times this below its chord, in voxels.
/// @param refraction coefficient: the Earth's radius to that of a ray of light; up to 1
[[nodiscard]] double sag_of_sight(double voxel_m, double refraction) noexcept;

/// The way of light between two points, in the coordinates of a world. Over a curved Earth it is a
/// parabola, followed here by chords that lie at most kMaxError_voxels off it. It is the same from
/// either end, bit for bit, so sight is symmetric. Level-0 voxels.
class SightLine {
public:
    static constexpr double kMaxError_voxels = 1.0 / 256;

    /// @param sag of sag_of_sight(); 0: a straight line
    SightLine(core::Vec3 one, core::Vec3 other, double sag) noexcept;

    /// Number of chords, at least 1.
    [[nodiscard]] std::uint32_t chords() const noexcept { return m_chords; }
    /// Where chord i begins and i - 1 ends; i from 0 to chords().
    [[nodiscard]] core::Vec3 joint(std::uint32_t i) const noexcept;

private:
    core::Vec3 m_from;
    core::Vec3 m_to;
    double m_sag_voxels;  ///< four times that in the middle
    std::uint32_t m_chords = 1;
};

/// What an observer's height counts from.
enum class HeightBase : std::uint8_t {
    kZero,    ///< the heights of the world
    kTop,     ///< the top of the highest voxel: roof, crown, deck
    kGround,  ///< the ground, below crowns and decks
};

/// A point that looks, as a user gives it.
struct Observer {
    double x = 0;  ///< level-0 voxels
    double z = 0;  ///< level-0 voxels
    double height_m = 0;
    HeightBase base = HeightBase::kZero;
    std::string text;  ///< for messages
};

/// Finds where observers are, among the voxels that the scene's analysis uses. Blocks while boxes
/// are loaded.
/// @param scene its camera is that of the cells
/// @throws UsageError for one beyond the world or inside a voxel, and where there is nothing that
/// its height could count from; Error where that could not be read
[[nodiscard]] scene::PointList place_observers(std::span<const Observer> observers,
                                               const scene::Scene& scene,
                                               blocks::BlockManager& blocks);

}  // namespace terravox::analyse
