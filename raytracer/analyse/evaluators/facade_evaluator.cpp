#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <utility>
#include <vector>

#include "common/util/det_math.hpp"
#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/analyse/evaluators/plane_light.hpp"
#include "raytracer/core/base/material_groups.hpp"
#include "raytracer/core/base/ray.hpp"
#include "raytracer/core/base/scene_words.hpp"

namespace terravox::analyse {
namespace {

/// A cell of the disc, seen from outside of the wall.
struct Cell {
    int along = 0;  ///< to the left
    int out = 0;
    bool is_solid = false;
};
using Cells = std::vector<Cell>;

/// Lines of how many angles are tried, and which ones.
constexpr int kAngles = 61;
double angle_deg(int number) noexcept {
    constexpr double kStep_deg = 2.5;
    return (number - kAngles / 2) * kStep_deg;
}

/// How well lines part the solid cells from the others.
struct Fit {
    double wrong = 1;      ///< share of the cells on the wrong side of the best line
    double angle_deg = 0;  ///< of its normal to the left of outwards: the middle of the best ones

    /// A face belongs rather to the wall that looks more its way.
    [[nodiscard]] bool is_better_than(const Fit& other) const noexcept {
        return std::pair{wrong, std::abs(angle_deg)} <
               std::pair{other.wrong, std::abs(other.angle_deg)};
    }
};

/// Cells on the wrong side of the best line of an angle.
int wrong_at(double degrees, const Cells& cells) {
    const det::SinCos angle = det::sin_cos(degrees * det::kPi / 180);
    std::vector<std::pair<double, bool>> far;
    far.reserve(cells.size());
    int wrong = 0;
    for (const Cell& cell : cells) {
        far.emplace_back(cell.along * angle.sin + cell.out * angle.cos, cell.is_solid);
        wrong += cell.is_solid ? 1 : 0;
    }
    std::sort(far.begin(), far.end());
    int least = wrong;
    for (std::size_t i = 0; i < far.size(); ++i) {
        wrong += far[i].second ? -1 : 1;
        // Cells at one distance are on one side.
        constexpr double kSame = 1e-9;
        if (i + 1 == far.size() || far[i + 1].first > far[i].first + kSame)
            least = std::min(least, wrong);
    }
    return least;
}

Fit measure_fit(const Cells& cells) {
    int least = static_cast<int>(cells.size());
    double sum_deg = 0;
    int angles = 0;
    for (int i = 0; i < kAngles; ++i) {
        const int wrong = wrong_at(angle_deg(i), cells);
        if (wrong < least) {
            least = wrong;
            sum_deg = 0;
            angles = 0;
        }
        if (wrong == least) {
            sum_deg += angle_deg(i);
            ++angles;
        }
    }
    return {static_cast<double>(least) / static_cast<double>(cells.size()), sum_deg / angles};
}

/// Towards the outside of a wall; x east, z south.
core::Vec3 to_direction(core::WallSide side) noexcept {
    switch (side) {
        case core::WallSide::kNorth: return {0, 0, -1};
        case core::WallSide::kEast: return {1, 0, 0};
        case core::WallSide::kSouth: return {0, 0, 1};
        case core::WallSide::kWest: break;
    }
    return {-1, 0, 0};
}

/// Which cells around one are as high as it: a window of 7 x 7 cells, seen as a disc.
class WallOutline {
public:
    static constexpr int kEdge = 7;
    static constexpr int kRadius = kEdge / 2;
    static constexpr std::uint32_t kCells = kEdge * kEdge;
    static constexpr std::uint32_t kOfCell = kCells / 2;  ///< the place of the cell itself

    WallOutline() noexcept { add(kOfCell); }
    /// From bits().
    explicit WallOutline(std::uint64_t bits) noexcept : m_bits(bits) {}

    /// Steps of a place, row by row from the north-west, from the cell.
    [[nodiscard]] static int find_east(std::uint32_t place) noexcept {
        return static_cast<int>(place % kEdge) - kRadius;
    }
    [[nodiscard]] static int find_south(std::uint32_t place) noexcept {
        return static_cast<int>(place / kEdge) - kRadius;
    }
    /// Whether a place belongs to the disc. The others need not be known.
    [[nodiscard]] static bool is_near(std::uint32_t place) noexcept {
        // The disc of radius 3.3 has 37 cells, and is the same in eight directions.
        constexpr int kRadiusSquared = 10;
        const int east = find_east(place);
        const int south = find_south(place);
        return east * east + south * south <= kRadiusSquared;
    }

    void add(std::uint32_t place) noexcept { m_bits |= std::uint64_t{1} << place; }
    [[nodiscard]] bool has(std::uint32_t place) const noexcept {
        return ((m_bits >> place) & 1) != 0;
    }
    [[nodiscard]] std::uint64_t bits() const noexcept { return m_bits; }

    /// The normal of the wall, of unit length and level: that of the straight lines that part the
    /// cells of the disc best into those of the cell's building, which are connected with it by
    /// sides or corners, and the others. Of many lines that are as good it is the mean. Cells of a
    /// half plane give its normal, whatever its angle to the grid, within some degrees. Where the
    /// whole disc has no such line, as at the corner of a building, the half of it along the wall
    /// that has one decides.
    /// @param side of the cell at which the wall is; the normal is less than 76 degrees off it
    [[nodiscard]] core::Vec3 normal(core::WallSide side) const noexcept {
        const core::Vec3 outwards = to_direction(side);
        const core::Vec3 left{outwards.z, 0, -outwards.x};
        const std::uint64_t solid = connected();
        Cells disc;
        Cells left_half;
        Cells right_half;
        for (std::uint32_t place = 0; place < kCells; ++place) {
            if (!is_near(place))
                continue;
            const core::Vec3 step{static_cast<double>(find_east(place)), 0,
                                  static_cast<double>(find_south(place))};
            const Cell cell{static_cast<int>(core::dot(step, left)),
                            static_cast<int>(core::dot(step, outwards)),
                            ((solid >> place) & 1) != 0};
            disc.push_back(cell);
            if (cell.along >= 0)
                left_half.push_back(cell);
            if (cell.along <= 0)
                right_half.push_back(cell);
        }
        Fit best = measure_fit(disc);
        if (best.wrong > 0) {
            const Fit halves[] = {measure_fit(left_half), measure_fit(right_half)};
            const Fit& half = halves[0].is_better_than(halves[1]) ? halves[0] : halves[1];
            if (half.wrong < best.wrong)
                best = half;
        }
        const det::SinCos angle = det::sin_cos(best.angle_deg * det::kPi / 180);
        return outwards * angle.cos + left * angle.sin;
    }

private:
    [[nodiscard]] std::uint64_t connected() const noexcept {
        std::uint64_t found = std::uint64_t{1} << kOfCell;
        for (std::uint64_t before = 0; before != found;) {
            before = found;
            for (std::uint32_t place = 0; place < kCells; ++place) {
                if (!is_near(place) || !has(place))
                    continue;
                for (std::uint32_t other = 0; other < kCells; ++other) {
                    const bool is_beside = std::abs(find_east(place) - find_east(other)) <= 1 &&
                                           std::abs(find_south(place) - find_south(other)) <= 1;
                    if (is_beside && ((found >> other) & 1) != 0)
                        found |= std::uint64_t{1} << place;
                }
            }
        }
        return found;
    }

    std::uint64_t m_bits = 0;
};

// What a ray is for, in its stream. Those of places of the outline follow.
constexpr std::uint32_t kRoof = 0;  ///< of the cell
constexpr std::uint32_t kFoot = 1;  ///< of the wall, in the neighbouring cell
constexpr std::uint32_t kWall = 2;  ///< level, against the wall
constexpr std::uint32_t kAround = 3;

/// Eaves reach over a wall by less than this.
constexpr double kMaxEaves_m = 2;

// What a cell knows while its rays are on their way is kept in its bands, until PlaneLight keeps
// its own there. Its band of holes stays where it is.
struct Wall {
    float hole = 0;
    float top = 0;      ///< of the cell, level-0 voxels
    float level = 0;    ///< of the voxels
    float waiting = 0;  ///< rays around that are on their way
    float bottom = 0;   ///< of the storey, level-0 voxels
    float height = 0;   ///< the same
    float forward = 0;  ///< from the start of the level ray to that of the light's, level-0 voxels
    std::uint32_t outline[2] = {};
    float unused[7] = {};

    [[nodiscard]] static Wall of(const core::Bands& bands) noexcept {
        return std::bit_cast<Wall>(bands);
    }
    void keep_in(core::Bands& bands) const noexcept { bands = std::bit_cast<core::Bands>(*this); }

    [[nodiscard]] WallOutline seen() const noexcept {
        return WallOutline(std::uint64_t{outline[1]} << 32 | outline[0]);
    }
    void keep(const WallOutline& now) noexcept {
        outline[0] = static_cast<std::uint32_t>(now.bits());
        outline[1] = static_cast<std::uint32_t>(now.bits() >> 32);
    }
};
static_assert(sizeof(Wall) == sizeof(core::Bands));

/// Whether a ray has met vegetation or a wire, which may touch a building or hang over it.
bool is_loose(const walk::TracedRay& ray) noexcept {
    const voxel::Material material = ray.hit.attr.material;
    return voxel::is_plant(material) || material == voxel::Material::kTrunk ||
           material == voxel::Material::kWire;
}

/// Of the wall between a cell of a building and a lower neighbour; core::kNoData: none.
enum class FacadeBand : std::uint8_t {
    kHole,
    kTotal,  ///< of all that follows, kWh/m2 of the wall
    kBeam,
    kDiffuse,
    kReflected,
    kSunHours,  ///< for which the sun shines on the wall
    kSkyView,   ///< share of the light of an even sky, [0, 0.5]
    kAzimuth,   ///< where the wall looks to, degrees clockwise from the map's north
    kBottom,    ///< of the storey, metres
    kHeight,    ///< of the storey's wall, metres
    kArea,      ///< of the wall, m2: less than the face of the voxels where the wall is oblique
};

constexpr RasterBand kFacadeBands[] = {
    {"kwh_m2", "kWh/m2"},    {"beam", "kWh/m2"}, {"diffuse", "kWh/m2"},
    {"reflected", "kWh/m2"}, kSunHoursBand,      {"sky_view"},
    {"azimuth", "degree"},   {"bottom", "m"},    {"height", "m"},
    {"area", "m2"},          kHoleBand,
};

/// Measures FacadeBand: the light on one storey of the wall between a cell of a building and
/// its lower neighbour on the side that the scene names.
///
/// Vertical rays find the top of the building and, in the neighbouring cell, the foot of the wall,
/// both below crowns. A level ray from the middle of the neighbouring cell tells whether there is a
/// wall at the storey's height. Rays around the cell find the outline of the building there, whose
/// normal is that of the wall: walls of voxels are stairs. From the start of the level ray the
/// light is gathered (PlaneLight). A cell's values depend on no other cell's.
class FacadeEvaluator final : public CellEvaluator {
public:
    FacadeEvaluator(const shade::View& view, const Sunlight& sunlight) noexcept
        : m_view(view),
          m_side(view.scene.analysis.side),
          m_outwards(to_direction(m_side)),
          m_spacing(cell_spacing(view)),
          m_storey(view.scene.analysis.storey_m / view.voxel_m),
          m_light(view, sunlight, PlaneLight::Behind::kFree) {}

    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override {
        const bool is_first = ray.kind == walk::RayKind::kPrimary && ray.stream == kRoof;
        if (!is_first && has_hole(sum.bands))
            return;
        if (is_hole(ray)) {
            sum.bands = no_values(true);
        } else if (ray.kind != walk::RayKind::kPrimary) {
            finish_if(m_light.take_through_crowns(ray, sum, next), ray.ray.origin.y, sum);
        } else if (ray.stream == kRoof) {
            shade_cell(ray, sum, next);
        } else if (ray.stream == kFoot) {
            shade_foot(ray, sum, next);
        } else if (ray.stream == kWall) {
            shade_wall(ray, sum, next);
        } else {
            shade_around(ray, sum, next);
        }
    }
    [[nodiscard]] walk::FanDirections directions(std::uint32_t stream) const override {
        return m_light.directions(stream);
    }
    void shade_fan(const walk::TracedRay& fan, walk::FanEnds ends, shade::SampleSum& sum,
                   std::vector<walk::TracedRay>& next) const override {
        if (ends.holes != 0)
            sum.bands = no_values(true);
        else
            finish_if(m_light.take_fan(fan, ends, *this, sum, next), fan.ray.origin.y, sum);
    }

private:
    void shade_cell(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const {
        sum.bands = no_values(false);
        if (ray.end != walk::WalkEnd::kHit)
            return;
        if (is_loose(ray)) {
            next.push_back(below(ray));
            return;
        }
        if (!core::is_of_building(ray.hit.attr.material))
            return;
        Wall wall;
        wall.top = static_cast<float>(find_top(ray.hit));
        wall.level = ray.hit.level;
        wall.keep_in(sum.bands);
        next.push_back(ray_beside(m_view, ray, m_outwards.x * m_spacing, m_outwards.z * m_spacing));
        next.back().stream = kFoot;
    }
    void shade_foot(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const {
        if (ray.end == walk::WalkEnd::kHit && is_loose(ray)) {
            next.push_back(below(ray));
            return;
        }
        auto wall = Wall::of(sum.bands);
        sum.bands = no_values(false);
        // Beyond the data there is nothing that a wall could look at.
        if (ray.end != walk::WalkEnd::kHit)
            return;
        const double foot = find_top(ray.hit);
        const auto top = static_cast<double>(wall.top);
        const int level = static_cast<int>(wall.level);
        const double edge = det::exp2_int(level);
        if (top <= foot || is_same_surface(m_spacing, top - foot, edge))
            return;
        const double bottom = foot + m_view.scene.analysis.storey * m_storey;
        const double height = std::min(m_storey, top - bottom);
        if (height <= 0)
            return;
        wall.bottom = static_cast<float>(bottom);
        wall.height = static_cast<float>(height);
        wall.keep_in(sum.bands);
        walk::TracedRay& out = next.emplace_back();
        out.ray = {{ray.ray.origin.x, bottom + height / 2, ray.ray.origin.z}, m_outwards * -1.0};
        out.state = core::RayState(out.ray);
        out.state.start_in(voxel_at(out.ray.origin, level), level);
        out.sample = ray.sample;
        out.stream = kWall;
    }
    void shade_wall(const walk::TracedRay& ray, shade::SampleSum& sum,
                    std::vector<walk::TracedRay>& next) const {
        auto wall = Wall::of(sum.bands);
        const double edge = det::exp2_int(static_cast<int>(wall.level));
        const double farthest = m_spacing + std::max(kMaxEaves_m / m_view.voxel_m, edge);
        const bool is_near = ray.end == walk::WalkEnd::kHit && ray.hit.t < farthest;
        if (is_near && is_loose(ray)) {
            next.push_back(through(ray));
            return;
        }
        // Open below the roof, or no wall of a building.
        if (!is_near || !core::is_of_building(ray.hit.attr.material)) {
            sum.bands = no_values(false);
            return;
        }
        wall.forward = static_cast<float>(std::max(ray.hit.t - edge / 2, 0.0));
        wall.keep(WallOutline());
        const std::size_t before = next.size();
        for (std::uint32_t place = 0; place < WallOutline::kCells; ++place) {
            if (place == WallOutline::kOfCell || !WallOutline::is_near(place))
                continue;
            const core::Vec3 step =
                m_outwards * -1.0 + core::Vec3{static_cast<double>(WallOutline::find_east(place)),
                                               0,
                                               static_cast<double>(WallOutline::find_south(place))};
            next.push_back(ray_beside(m_view, ray, step.x * m_spacing, step.z * m_spacing));
            next.back().stream = kAround + place;
        }
        wall.waiting = static_cast<float>(next.size() - before);
        wall.keep_in(sum.bands);
    }
    void shade_around(const walk::TracedRay& ray, shade::SampleSum& sum,
                      std::vector<walk::TracedRay>& next) const {
        const bool is_hit = ray.end == walk::WalkEnd::kHit;
        if (is_hit && is_loose(ray)) {
            next.push_back(below(ray));
            return;
        }
        auto wall = Wall::of(sum.bands);
        const double middle =
            static_cast<double>(wall.bottom) + static_cast<double>(wall.height) / 2;
        const std::uint32_t place = ray.stream - kAround;
        if (is_hit && find_top(ray.hit) > middle) {
            WallOutline outline = wall.seen();
            outline.add(place);
            wall.keep(outline);
        }
        wall.waiting -= 1;
        wall.keep_in(sum.bands);
        if (wall.waiting > 0)
            return;
        const core::Vec3 normal = wall.seen().normal(m_side);
        const int level = static_cast<int>(wall.level);
        const double edge = det::exp2_int(level);
        const core::Vec3 cell{ray.ray.origin.x - WallOutline::find_east(place) * m_spacing, middle,
                              ray.ray.origin.z - WallOutline::find_south(place) * m_spacing};
        // Stairs reach over the line that is as far from this face by up to half of a voxel.
        const double along = core::dot(normal, m_outwards);
        const double lift = edge / 2 * std::sqrt(std::max(1 - along * along, 0.0));
        const core::Vec3 from =
            cell + m_outwards * (m_spacing - static_cast<double>(wall.forward)) + normal * lift;
        const FanStart start = start_at(from, level, ray.sample);
        finish_if(m_light.begin(normal, wall.height, start, sum, next), middle, sum);
    }
    /// Makes a wall's values of its light.
    /// @param middle height of the middle of the storey's wall, level-0 voxels
    void finish_if(bool is_complete, double middle, shade::SampleSum& sum) const noexcept {
        if (!is_complete)
            return;
        const PlaneLight::Result light = m_light.result(sum.bands);
        const double height_m = static_cast<double>(light.kept) * m_view.voxel_m;
        const double along = core::dot(light.normal, m_outwards);
        core::Bands out{};
        at(out, FacadeBand::kTotal) = static_cast<float>(light.total());
        at(out, FacadeBand::kBeam) = static_cast<float>(light.beam);
        at(out, FacadeBand::kDiffuse) = static_cast<float>(light.diffuse);
        at(out, FacadeBand::kReflected) = static_cast<float>(light.reflected);
        at(out, FacadeBand::kSunHours) = light.sun_hours;
        at(out, FacadeBand::kSkyView) = static_cast<float>(light.sky_view);
        at(out, FacadeBand::kAzimuth) = static_cast<float>(azimuth_deg(light.normal));
        at(out, FacadeBand::kBottom) = static_cast<float>(middle * m_view.voxel_m - height_m / 2);
        at(out, FacadeBand::kHeight) = static_cast<float>(height_m);
        at(out, FacadeBand::kArea) =
            static_cast<float>(m_spacing * m_view.voxel_m * height_m * along);
        sum.bands = out;
    }

    const shade::View& m_view;
    const core::WallSide m_side;
    const core::Vec3 m_outwards;  ///< to_direction(m_side)
    const double m_spacing;       ///< of cells, level-0 voxels
    const double m_storey;        ///< height of one, level-0 voxels
    const PlaneLight m_light;
};

}  // namespace

template <>
constexpr Analysis kAnalysis<AnalysisKind::kFacade>{kFacadeBands, make<FacadeEvaluator>,
                                                    SunUse::kEnergy, SkyUse::kFromWalls};
template const Analysis& find_analysis<AnalysisKind::kFacade>() noexcept;

}  // namespace terravox::analyse
