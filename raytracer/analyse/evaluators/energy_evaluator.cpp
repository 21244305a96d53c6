#include <bit>
#include <cmath>
#include <cstddef>

#include "common/util/det_math.hpp"
#include "raytracer/analyse/evaluators/cell_evaluator.hpp"
#include "raytracer/analyse/evaluators/plane_light.hpp"

namespace terravox::analyse {
namespace {

enum class EnergyBand : std::uint8_t {
    kHole,
    kTotal,  ///< of all that follows, kWh/m2 of the surface
    kBeam,
    kDiffuse,
    kReflected,
    kSlope,     ///< of the surface that the energy is of, degrees
    kAspect,    ///< where it falls to, degrees clockwise from north; kNoData where it is level
    kSunHours,  ///< for which the sun shines on the surface
    kMaterial,  ///< of the voxel that is measured; has a value behind a hole, too
};

// The plane goes through the heights of so many cells a side.
constexpr int kWindow = 5;
constexpr int kRadius = kWindow / 2;
constexpr std::uint32_t kNeighbours = kWindow * kWindow;
constexpr std::uint32_t kOfCell = kNeighbours / 2;  ///< place of the cell itself in the window

// What a cell knows while its rays are on their way is kept in its bands: first the heights around
// it, then, by PlaneLight, its plane and the light that has reached it. Its band of holes stays
// where it is.
struct Heights {
    float hole = 0;
    float top = 0;      ///< of the cell, level-0 voxels
    float level = 0;    ///< of its voxel
    float waiting = 0;  ///< neighbours whose rays are on their way
    HeightSums sums;
    float unused = 0;
    float material = 0;
};
static_assert(sizeof(Heights) == sizeof(core::Bands));
static_assert(offsetof(Heights, material) == PlaneLight::kKept * sizeof(float));

Heights choose_memory(const core::Bands& bands) noexcept {
    return std::bit_cast<Heights>(bands);
}
void keep(const Heights& memory, core::Bands& bands) noexcept {
    bands = std::bit_cast<core::Bands>(memory);
}

int find_east(std::uint32_t place) noexcept {
    return static_cast<int>(place % kWindow) - kRadius;
}
int find_south(std::uint32_t place) noexcept {
    return static_cast<int>(place / kWindow) - kRadius;
}

/// What is left of a cell, one of whose rays has met a hole.
core::Bands behind_hole(const core::Bands& memory) noexcept {
    core::Bands out = no_values(true);
    at(out, EnergyBand::kMaterial) = memory[PlaneLight::kKept];
    return out;
}

constexpr RasterBand kEnergyBands[] = {
    {"kwh_m2", "kWh/m2", {"Energy of sun and sky", Ramp::kWarm, 0.0}},
    {"beam", "kWh/m2", {"Energy directly from the sun", Ramp::kWarm, 0.0}},
    {"diffuse", "kWh/m2", {"Energy from the sky", Ramp::kWarm, 0.0}},
    {"reflected", "kWh/m2", {"Energy from what is around", Ramp::kWarm, 0.0, {}, kNotReported}},
    kSlopeBand,
    kAspectBand,
    kSunHoursBand,
    kMaterialBand,
    kHoleBand,
};

/// Measures EnergyBand. A cell's surface is the plane through the heights of the cells around
/// it, to which it sends vertical rays of its own, so that its values depend on no other cell's.
/// The light on the plane is that of PlaneLight.
class EnergyEvaluator final : public CellEvaluator {
public:
    EnergyEvaluator(const shade::View& view, const Sunlight& sunlight) noexcept
        : m_view(view),
          m_spacing(cell_spacing(view)),
          m_light(view, sunlight, PlaneLight::Behind::kSeen) {}

    [[nodiscard]] walk::TracedRay primary(const core::Ray& ray,
                                          std::uint32_t sample) const noexcept override {
        walk::TracedRay out = cell_ray(ray, sample);
        out.stream = kOfCell;
        return out;
    }
    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override {
        if (ray.kind == walk::RayKind::kPrimary && ray.stream == kOfCell) {
            if (lands(ray, m_view, sum, next))
                send_to_neighbours(ray, sum, next);
            return;
        }
        if (has_hole(sum.bands))
            return;
        if (ray.end == walk::WalkEnd::kHit && ray.hit.hole)
            sum.bands = behind_hole(sum.bands);
        else if (ray.kind == walk::RayKind::kPrimary)
            shade_neighbour(ray, sum, next);
        else
            finish_if(m_light.take_through_crowns(ray, sum, next), sum);
    }
    [[nodiscard]] walk::FanDirections directions(std::uint32_t stream) const override {
        return m_light.directions(stream);
    }
    void shade_fan(const walk::TracedRay& fan, walk::FanEnds ends, shade::SampleSum& sum,
                   std::vector<walk::TracedRay>& next) const override {
        if (ends.holes != 0)
            sum.bands = behind_hole(sum.bands);
        else
            finish_if(m_light.take_fan(fan, ends, *this, sum, next), sum);
    }

private:
    void shade_neighbour(const walk::TracedRay& ray, shade::SampleSum& sum,
                         std::vector<walk::TracedRay>& next) const {
        const CellStep step = cell_step_at(ray, m_view.scene.analysis.surface);
        if (step == CellStep::kDescend) {
            next.push_back(below(ray));
            return;
        }
        auto heights = choose_memory(sum.bands);
        const int east = find_east(ray.stream);
        const int south = find_south(ray.stream);
        const int level = static_cast<int>(heights.level);
        const double voxel = det::exp2_int(level);
        if (step == CellStep::kMeasure) {
            const auto height = static_cast<float>(find_top(ray.hit)) - heights.top;
            const double distance = std::sqrt(east * east + south * south) * m_spacing;
            if (is_same_surface(distance, static_cast<double>(height), voxel))
                heights.sums.add(east, south, height);
        }
        heights.waiting -= 1;
        keep(heights, sum.bands);
        if (heights.waiting > 0)
            return;
        const CellPlane plane = plane_through(heights.sums, m_spacing, voxel);
        const core::Vec3 from{ray.ray.origin.x - east * m_spacing,
                              static_cast<double>(heights.top) + plane.lift,
                              ray.ray.origin.z - south * m_spacing};
        const FanStart start = start_at(from, level, ray.sample);
        finish_if(m_light.begin(plane.normal(), heights.material, start, sum, next), sum);
    }
    void send_to_neighbours(const walk::TracedRay& ray, shade::SampleSum& sum,
                            std::vector<walk::TracedRay>& next) const {
        Heights heights;
        heights.sums.add(0, 0, 0);
        heights.top = static_cast<float>(find_top(ray.hit));
        heights.level = ray.hit.level;
        heights.waiting = kNeighbours - 1;
        heights.material = static_cast<float>(ray.hit.attr.material);
        keep(heights, sum.bands);
        for (std::uint32_t place = 0; place < kNeighbours; ++place) {
            if (place == kOfCell)
                continue;
            walk::TracedRay out = ray_beside(m_view, ray, find_east(place) * m_spacing,
                                             find_south(place) * m_spacing);
            out.stream = place;
            next.push_back(out);
        }
    }
    /// Makes a cell's values of its light.
    void finish_if(bool is_complete, shade::SampleSum& sum) const noexcept {
        if (!is_complete)
            return;
        const PlaneLight::Result light = m_light.result(sum.bands);
        const double sine =
            std::sqrt(light.normal.x * light.normal.x + light.normal.z * light.normal.z);
        constexpr double kDegPerRad = 180 / det::kPi;
        core::Bands out{};
        at(out, EnergyBand::kTotal) = static_cast<float>(light.total());
        at(out, EnergyBand::kBeam) = static_cast<float>(light.beam);
        at(out, EnergyBand::kDiffuse) = static_cast<float>(light.diffuse);
        at(out, EnergyBand::kReflected) = static_cast<float>(light.reflected);
        at(out, EnergyBand::kSlope) =
            static_cast<float>(det::atan2(sine, light.normal.y) * kDegPerRad);
        at(out, EnergyBand::kAspect) =
            sine > 0 ? static_cast<float>(azimuth_deg(light.normal)) : core::kNoData;
        at(out, EnergyBand::kSunHours) = light.sun_hours;
        at(out, EnergyBand::kMaterial) = light.kept;
        sum.bands = out;
    }

    const shade::View& m_view;
    const double m_spacing;  ///< of cells, level-0 voxels
    const PlaneLight m_light;
};

}  // namespace

template <>
constexpr Analysis kAnalysis<AnalysisKind::kEnergy>{kEnergyBands, make<EnergyEvaluator>,
                                                    SunUse::kEnergy, SkyUse::kFromCells};
template const Analysis& find_analysis<AnalysisKind::kEnergy>() noexcept;

}  // namespace terravox::analyse
