#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "voxelserver/tools/survey/plane.hpp"
#include "voxelserver/tools/survey/randomness.hpp"
#include "voxelserver/tools/survey/square_model.hpp"

namespace terravox::survey {

/// One laser pulse, identified by the point where it would hit the bare ground.
struct Pulse {
    Vec2 foot;                ///< on the ground, place frame
    Vec2 lean;                ///< metres towards the aircraft for each metre up
    double angle_deg = 0;     ///< from straight down; positive to the right of the flight
    double time_s = 0;        ///< adjusted standard GPS time
    std::uint64_t key = 0;    ///< source of all randomness of this pulse
    std::uint16_t strip = 0;  ///< point source id, [1, 65535]
    bool forward = false;     ///< direction of the mirror
    bool strip_edge = false;  ///< first or last of its scan line
};

/// The flight of the aircraft: parallel strips that overlap by about 30 %, flown to and fro, at a
/// small angle to north; scan lines across each strip. The pattern covers the whole plane and
/// depends on seed and density only, so that every square sees its part of the same flight.
class ScanPattern {
public:
    /// @param density pulses on each square metre, averaged over strips and overlaps
    ScanPattern(std::uint64_t seed, double density);

    static constexpr double kFlightHeight_m = 1200;
    static constexpr double kSwath_m = 660;
    static constexpr double kStripDistance_m = 470;
    static constexpr double kSpeed_m_s = 60;
    /// Greatest lean of any pulse: metres sideways for each metre up.
    static constexpr double kMaxLean = 0.5 * kSwath_m / kFlightHeight_m;

    /// Calls visit(pulse) for each pulse that may hit the ground in `area`, strip by strip, scan
    /// line by scan line in the order of the flight. A few pulses just outside of the area are
    /// visited too.
    template <class Visit>
    void visit(const Box2& area, const Visit& visit) const;

private:
    struct Line {
        std::int64_t strip = 0;
        std::int64_t number = 0;
        double forward_m = 0;
    };
    /// Numbers of strips, lines or pulses, [first, last].
    struct Span {
        std::int64_t first = 0;
        std::int64_t last = -1;
    };

    [[nodiscard]] Span strips_over(const Box2& area) const noexcept;
    [[nodiscard]] Span lines_over(const Box2& area) const noexcept;
    [[nodiscard]] Line line(std::int64_t strip, std::int64_t number) const noexcept;
    [[nodiscard]] Span clip(const Line& line, const Box2& area) const noexcept;
    [[nodiscard]] Pulse pulse(const Line& line, std::int64_t number) const noexcept;
    [[nodiscard]] static Vec2 place(double across_m, double forward_m) noexcept;
    [[nodiscard]] static bool flown_north(std::int64_t strip) noexcept { return (strip & 1) == 0; }

    std::uint64_t m_seed;
    double m_spacing_m;  ///< between pulses of a line and between lines, on average
    std::int64_t m_pulses_per_line;
};

template <class Visit>
void ScanPattern::visit(const Box2& area, const Visit& visit) const {
    const Span strips = strips_over(area);
    const Span lines = lines_over(area);
    for (auto s = strips.first; s <= strips.last; ++s) {
        const std::int64_t step = flown_north(s) ? 1 : -1;
        for (auto n = step > 0 ? lines.first : lines.last; n >= lines.first && n <= lines.last;
             n += step) {
            const Line scan = line(s, n);
            const Span range = clip(scan, area);
            for (auto i = range.first; i <= range.last; ++i)
                visit(pulse(scan, i));
        }
    }
}

enum class ObstacleKind : std::uint8_t { kBuilding, kBridge, kTree, kPylon, kWire };

struct Obstacle {
    ObstacleKind kind;
    std::uint32_t index;  ///< in the model's list of that kind
};

/// Finds the obstacles that a pulse may hit above the ground: a grid of cells of 8 m; each lists
/// what a pulse whose foot is in the cell can touch at the greatest lean. Immutable, thread-safe;
/// holds no reference to the model.
class ObstacleGrid {
public:
    explicit ObstacleGrid(const SquareModel& model);
    /// @param foot in the square or kObstacleMargin_m around it
    [[nodiscard]] std::span<const Obstacle> at(Vec2 foot) const noexcept {
        const auto cell = static_cast<std::size_t>((foot.y - m_area.y0) * kPerCell) * m_columns +
                          static_cast<std::size_t>((foot.x - m_area.x0) * kPerCell);
        return {m_items.data() + m_starts[cell], m_starts[cell + 1] - m_starts[cell]};
    }

private:
    static constexpr double kCell_m = 8;
    static constexpr double kPerCell = 1.0 / kCell_m;
    template <class Visit>
    void for_each_cell(const Box2& box, const Visit& visit) const;
    template <class Visit>
    void for_each_obstacle(const SquareModel& model, const Visit& visit) const;

    Box2 m_area;
    std::size_t m_columns;
    std::size_t m_rows;
    std::vector<std::uint32_t> m_starts;
    std::vector<Obstacle> m_items;
};

inline constexpr double kObstacleMargin_m = 32;

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
