#include "raytracer/analyse/evaluators/sight.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/walk/walk.hpp"

namespace terravox::analyse {
namespace {

using util::number_text;

// The mean radius of the Earth (IUGG).
constexpr double kEarth_m = 6371008.8;
// Far more than any horizon needs; it only bounds what a scene can ask for.
constexpr double kMaxChords = 65536;

bool comes_first(core::Vec3 a, core::Vec3 b) noexcept {
    if (a.x != b.x)
        return a.x < b.x;
    return a.z != b.z ? a.z < b.z : a.y < b.y;
}

/// A point on the grid of on_grid(), on which lines of sight begin and end: computed in two ways it
/// is the same.
core::Vec3 on_sight_grid(core::Vec3 p) noexcept {
    return {on_grid(p.x), on_grid(p.y), on_grid(p.z)};
}

/// Square of the distance on the map.
double horizontal_distance2(core::Vec3 a, core::Vec3 b) noexcept {
    const core::Vec3 d = b - a;
    return d.x * d.x + d.z * d.z;
}

/// How strongly lines of sight sag in a world, whose heights are measured from a curved surface:
/// a line of length d lies up to d^2/4 times this below its chord, in voxels.
/// @param refraction coefficient: the Earth's radius to that of a ray of light; up to 1
// A height at the distance s from the end of a line of length d lies (1 - k) s (d - s) / 2R above
// the straight line between its ends, seen from the curved surface that heights are measured from;
// so in the world's coordinates the line lies as much below. Ref: Baeyer, "Küstenvermessung", 1849
// (the coefficient k of refraction as a ratio of radii).
double sag_of_sight(double voxel_m, double refraction) noexcept {
    return (1 - refraction) * voxel_m / (2 * kEarth_m);
}

/// The way of light between two points, in the coordinates of a world. Over a curved Earth it is a
/// parabola, followed here by chords that lie at most kMaxError_voxels off it. It is the same from
/// either end, bit for bit, so sight is symmetric. Level-0 voxels.
class SightLine {
public:
    static constexpr double kMaxError_voxels = 1.0 / 256;

    /// @param sag of sag_of_sight(); 0: a straight line
    SightLine(core::Vec3 one, core::Vec3 other, double sag) noexcept : m_from(one), m_to(other) {
        if (comes_first(m_to, m_from))
            std::swap(m_from, m_to);
        const double distance2 = horizontal_distance2(m_from, m_to);
        m_sag_voxels = sag * distance2;
        // A chord of a parabola lies farthest off it in its middle: by a quarter of sag times its
        // length squared.
        const double wanted = std::ceil(std::sqrt(m_sag_voxels / (4 * kMaxError_voxels)));
        m_chords = static_cast<std::uint32_t>(std::clamp(wanted, 1.0, kMaxChords));
    }

    /// Number of chords, at least 1.
    [[nodiscard]] std::uint32_t chords() const noexcept { return m_chords; }
    /// Where chord i begins and i - 1 ends; i from 0 to chords().
    [[nodiscard]] core::Vec3 joint(std::uint32_t i) const noexcept {
        if (i == 0)
            return m_from;
        if (i >= m_chords)
            return m_to;
        const double share = static_cast<double>(i) / m_chords;
        core::Vec3 out = m_from + (m_to - m_from) * share;
        out.y -= m_sag_voxels * share * (1 - share);
        return out;
    }

private:
    core::Vec3 m_from;
    core::Vec3 m_to;
    double m_sag_voxels;  ///< four times that in the middle
    std::uint32_t m_chords = 1;
};

/// Places the observers of one analysis.
class Placing {
public:
    Placing(const voxel::WorldInfo& world, const walk::LevelCut& cut, blocks::BlockManager& blocks)
        : m_world(world), m_blocks(blocks), m_reader(blocks), m_walker(m_reader, cut) {}

    [[nodiscard]] std::array<double, 3> place(const Observer& observer) {
        check_area(observer);
        const double y = observer.height_m / m_world.voxel_m + find_base(observer);
        const core::Vec3 at = on_sight_grid({observer.x, y, observer.z});
        check_free(observer, at);
        return {at.x, at.y, at.z};
    }

private:
    [[noreturn]] static void refuse(const Observer& observer, const std::string& why) {
        throw util::UsageError("place the observer " + observer.text + ": " + why);
    }

    void check_area(const Observer& observer) const {
        const voxel::VoxelBounds& b = m_world.bounds;
        if (observer.x >= b.min[0] && observer.x < b.max[0] && observer.z >= b.min[2] &&
            observer.z < b.max[2])
            return;
        const bool is_placed = !m_world.crs.empty();
        const double unit = is_placed ? m_world.crs_units_per_voxel : 1;
        const double low = is_placed ? -b.max[2] * unit : b.min[2];
        const double high = is_placed ? -b.min[2] * unit : b.max[2];
        refuse(observer, std::string("it lies outside of the data; allowed: ") +
                             (is_placed ? "E " : "x ") + number_text(b.min[0] * unit, 10) + " to " +
                             number_text(b.max[0] * unit, 10) + (is_placed ? ", N " : ", z ") +
                             number_text(low, 10) + " to " + number_text(high, 10));
    }

    /// The first voxel that a vertical ray meets.
    [[nodiscard]] std::optional<walk::Hit> met(const Observer& observer,
                                               const std::optional<walk::Hit>& hit) const {
        if (hit && hit->hole) {
            m_blocks.check_world();
            throw util::Error("place the observer " + observer.text +
                              ": the data there cannot be read");
        }
        return hit;
    }

    /// Height that the observer's counts from, level-0 voxels.
    [[nodiscard]] double find_base(const Observer& observer) {
        if (observer.base == HeightBase::kZero)
            return 0;
        const auto surface = observer.base == HeightBase::kTop ? core::AnalysisSurface::kTop
                                                               : core::AnalysisSurface::kGround;
        walk::TracedRay ray = cell_ray(above(observer), 0);
        std::optional<walk::Hit> hit = met(observer, m_walker.first_hit(ray.ray));
        if (!hit)
            refuse(observer,
                   "there are no data at that place; allowed: a height of its own, E,N,H");
        const double top = find_top(*hit) * m_world.voxel_m;
        while (hit) {
            ray.end = walk::WalkEnd::kHit;
            ray.hit = *hit;
            const CellStep step = cell_step_at(ray, surface);
            if (step == CellStep::kMeasure)
                return find_top(*hit);
            if (step == CellStep::kNothing)
                break;
            ray = below(ray);
            hit = met(observer,
                      m_walker.first_hit_from(
                          ray.ray, {ray.state.voxel[0], ray.state.voxel[1], ray.state.voxel[2]},
                          ray.state.level));
        }
        refuse(observer, "the ground there is not known, inside of what is " +
                             number_text(top, 10) + " m high; allowed: E,N,+ABOVE on its top");
    }

    void check_free(const Observer& observer, core::Vec3 at) {
        if (at.y >= m_world.bounds.max[1])
            return;
        const std::optional<walk::Hit> hit = m_walker.first_hit({at, {0, -1, 0}});
        if (hit && hit->face != core::Face::kNone)
            return;
        (void)met(observer, hit);
        const walk::TracedRay down = cell_ray(above(observer), 0);
        const std::optional<walk::Hit> top = met(observer, m_walker.first_hit(down.ray));
        // Where there is nothing at all, there is nothing to be inside of.
        if (!top)
            return;
        refuse(observer, "at " + number_text(at.y * m_world.voxel_m, 10) + " m it lies " +
                             (hit ? "inside of something solid" : "below the ground") +
                             "; allowed: " + number_text(find_top(*top) * m_world.voxel_m, 10) +
                             " m and more, the top there");
    }

    /// A ray that starts above everything.
    [[nodiscard]] core::Ray above(const Observer& observer) const noexcept {
        return {{observer.x, static_cast<double>(m_world.bounds.max[1]) + 1, observer.z}, {}};
    }

    const voxel::WorldInfo& m_world;
    blocks::BlockManager& m_blocks;
    walk::BlockReader m_reader;
    walk::Walker m_walker;
};

}  // namespace

scene::PointList place_observers(std::span<const Observer> observers, const scene::Scene& scene,
                                 blocks::BlockManager& blocks) {
    const voxel::WorldInfo& world = blocks.world_info();
    const scene::Camera camera = scene::make_camera(scene, world, world.camera_bounds());
    const walk::LevelCut cut(world.bounds, camera, scene.quality.detail, scene.quality.level,
                             world.levels - 1);
    Placing placing(world, cut, blocks);
    scene::PointList out;
    for (const Observer& observer : observers)
        out.points.push_back(placing.place(observer));
    return out;
}

namespace {

// A point on the surface lies a little above it, in the air: a line of sight must not end in the
// face that it looks for.
constexpr double kMinTarget_voxels = 1.0 / 1024;

double measure_range2(const shade::View& view) noexcept {
    const double range_m = view.scene.analysis.range_m;
    const double range = range_m > 0 ? range_m / view.voxel_m : core::kFar;
    return range * range;
}

double measure_sag(const shade::View& view) noexcept {
    const auto& analysis = view.scene.analysis;
    return analysis.curvature ? sag_of_sight(view.voxel_m, analysis.refraction) : 0;
}

enum class SightBand : std::uint8_t {
    kHole,
    kSeen,      ///< number of observers that see the cell
    kDistance,  ///< to the nearest of those, metres; kNoData where there is none
    kClass,     ///< of the survey, of the voxel that is looked for
    kMaterial,
};

constexpr RasterBand kSightBands[] = {
    {"seen",
     "",
     {"Observers that see the place", Ramp::kMuch, 0.0, {}, true, !kClock, "not seen|seen"}},
    {"distance_m", "m", {"Distance to the nearest observer that sees it", Ramp::kMuch, 0.0}},
    kClassBand,
    kMaterialBand,
    kHoleBand,
};

/// Measures SightBand: from above the middle of each cell's top, or of its ground, a line of
/// sight to each of the scene's observers. A voxel of any material blocks it, leaves and panes as
/// well.
class SightEvaluator final : public CellEvaluator {
public:
    explicit SightEvaluator(const shade::View& view)
        : m_view(view),
          m_sag(measure_sag(view)),
          m_range2(measure_range2(view)),
          m_target_voxels(
              std::max(view.scene.analysis.target_m / view.voxel_m, kMinTarget_voxels)) {
        for (const std::array<double, 3>& at : view.scene.analysis.observers.points)
            m_observers.push_back(on_sight_grid({at[0], at[1], at[2]}));
    }

    // A line of sight sends its rays one after the other, and those of a wave end at different
    // times: one that begins with more of them stays large for longer.
    [[nodiscard]] std::size_t wave_pixels(std::size_t rays) const noexcept override {
        constexpr std::size_t kFactor = 4;
        return kFactor * rays / (1 + m_observers.size());
    }
    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override {
        if (ray.kind == walk::RayKind::kPrimary) {
            if (lands(ray, m_view, sum, next))
                send_to_observers(ray, sum, next);
            return;
        }
        if (has_hole(sum.bands))
            return;
        if (ray.end != walk::WalkEnd::kHit)
            arrive(ray, sum, next);
        else if (ray.hit.hole)
            sum.bands = no_values(true);
    }

private:
    void send_to_observers(const walk::TracedRay& ray, shade::SampleSum& sum,
                           std::vector<walk::TracedRay>& next) const {
        at(sum.bands, SightBand::kSeen) = 0;
        at(sum.bands, SightBand::kClass) = ray.hit.attr.source_class;
        at(sum.bands, SightBand::kMaterial) = static_cast<float>(ray.hit.attr.material);
        sum.point = on_sight_grid(
            {ray.ray.origin.x, find_top(ray.hit) + m_target_voxels, ray.ray.origin.z});
        for (std::size_t observer = 0; observer < m_observers.size(); ++observer)
            if (horizontal_distance2(m_observers[observer], sum.point) <= m_range2)
                next.push_back(along(line_to(observer, sum.point), observer, 0, ray.sample));
    }
    // At the end of a free chord: on along the line, or at its end the cell is seen.
    void arrive(const walk::TracedRay& ray, shade::SampleSum& sum,
                std::vector<walk::TracedRay>& next) const {
        const std::size_t observer = ray.stream % m_observers.size();
        const auto chord = static_cast<std::uint32_t>(ray.stream / m_observers.size()) + 1;
        const SightLine line = line_to(observer, sum.point);
        if (chord < line.chords()) {
            next.push_back(along(line, observer, chord, ray.sample));
            return;
        }
        const auto distance_m =
            static_cast<float>(core::length(m_observers[observer] - sum.point) * m_view.voxel_m);
        at(sum.bands, SightBand::kSeen) += 1;
        float& nearest = at(sum.bands, SightBand::kDistance);
        nearest = nearest == core::kNoData ? distance_m : std::min(nearest, distance_m);
    }
    [[nodiscard]] SightLine line_to(std::size_t observer, core::Vec3 target) const noexcept {
        return {m_observers[observer], target, m_sag};
    }
    [[nodiscard]] walk::TracedRay along(const SightLine& line, std::size_t observer,
                                        std::uint32_t chord, std::uint32_t sample) const noexcept {
        const core::Vec3 from = line.joint(chord);
        const core::Vec3 way = line.joint(chord + 1) - from;
        const double distance = core::length(way);
        walk::TracedRay out;
        out.kind = walk::RayKind::kSky;
        out.sample = sample;
        out.stream = chord * static_cast<std::uint32_t>(m_observers.size()) +
                     static_cast<std::uint32_t>(observer);
        out.t_max = distance;
        out.ray = {from, distance > 0 ? way * (1 / distance) : core::Vec3{0, 1, 0}};
        out.state = core::RayState(out.ray);
        // What lies outside of the world's bounds is free.
        if (!out.state.enter(m_view.cut.entry_bounds()) || out.state.t > out.t_max)
            out.end = walk::WalkEnd::kMiss;
        return out;
    }

    const shade::View& m_view;
    std::vector<core::Vec3> m_observers;
    const double m_sag;
    const double m_range2;         ///< of the horizontal distance, squared; level-0 voxels
    const double m_target_voxels;  ///< height of the point that is looked for above its voxel
};

}  // namespace

template <>
constexpr Analysis kAnalysis<AnalysisKind::kSight>{kSightBands, make<SightEvaluator>};
template const Analysis& find_analysis<AnalysisKind::kSight>() noexcept;

}  // namespace terravox::analyse
