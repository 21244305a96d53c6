#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>

#include "voxelserver/tools/survey/obstacles.hpp"
#include "voxelserver/tools/survey/scan_pattern.hpp"
#include "voxelserver/tools/survey/square_model.hpp"

namespace terravox::survey {

/// The classes that the survey uses (ASPRS LAS 1.4). Vegetation by height above the ground: low
/// below 3 m, medium below 10 m, high above. Roads are ground (2), as in most national surveys.
namespace las_class {
inline constexpr std::uint8_t kGround = 2;
inline constexpr std::uint8_t kLowVegetation = 3;
inline constexpr std::uint8_t kMediumVegetation = 4;
inline constexpr std::uint8_t kHighVegetation = 5;
inline constexpr std::uint8_t kBuilding = 6;
inline constexpr std::uint8_t kLowNoise = 7;
inline constexpr std::uint8_t kWater = 9;
inline constexpr std::uint8_t kWire = 14;
inline constexpr std::uint8_t kTower = 15;
inline constexpr std::uint8_t kBridge = 17;
inline constexpr std::uint8_t kHighNoise = 18;
}  // namespace las_class
inline constexpr double kMediumFrom_m = 3;
inline constexpr double kHighFrom_m = 10;

/// A measured point.
struct ScanPoint {
    Vec2 at;              ///< place frame
    double height_m = 0;  ///< sea level
    std::uint16_t intensity = 0;
    std::uint8_t classification = 0;
    std::uint8_t return_number = 1;
    std::uint8_t number_of_returns = 1;
};

/// The returns of one pulse, the first (the highest) first.
struct Returns {
    static constexpr int kMax = 6;
    std::array<ScanPoint, kMax> points;
    int count = 0;
};

/// Traces pulses through a square. Immutable, thread-safe; the model must outlive it.
class Scanner {
public:
    explicit Scanner(const SquareModel& model) : m_model(model), m_obstacles(model) {}
    /// @param pulse with its foot in the square or kObstacleMargin_m around it
    /// @return no points when the pulse is lost (water, a wall seen at a glancing angle)
    [[nodiscard]] Returns shoot(const Pulse& pulse) const noexcept;

private:
    /// A pulse with the ground under it: at height z it is at foot + lean * (z - foot_m).
    struct Ray {
        Vec2 foot;
        Vec2 lean;
        double foot_m = 0;
        [[nodiscard]] Vec2 at(double height_m) const noexcept {
            return foot + lean * (height_m - foot_m);
        }
    };
    struct Solid {
        double height_m = 0;
        std::uint8_t classification = 0;
        bool wall = false;
        double intensity = 14000;
    };
    struct Shot;

    void meet(Shot& shot, const Obstacle& obstacle) const noexcept;
    [[nodiscard]] static std::optional<Solid> hit(const Ray& ray,
                                                  const Building& building) noexcept;
    [[nodiscard]] static std::optional<Solid> hit(const Ray& ray, const Bridge& bridge) noexcept;
    [[nodiscard]] static std::optional<double> hit(const Ray& ray, const Wire& wire) noexcept;
    [[nodiscard]] static std::optional<double> enter(const Ray& ray, const Tree& tree) noexcept;
    void pass_crowns(Shot& shot) const noexcept;
    void reach_ground(Shot& shot) const noexcept;

    const SquareModel& m_model;
    ObstacleGrid m_obstacles;
};

}  // namespace terravox::survey
