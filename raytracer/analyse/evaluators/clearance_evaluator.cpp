#include <cstdint>

#include "common/util/det_math.hpp"
#include "raytracer/analyse/evaluators/cell_evaluator.hpp"

namespace terravox::analyse {
namespace {

enum class ClearanceBand : std::uint8_t {
    kHole,
    kHeight,    ///< of the air between the ground and the lowest thing above it, metres
    kMaterial,  ///< of that thing
};

constexpr RasterBand kClearanceBands[] = {
    {"clearance", "m", {"Free height above the ground", Ramp::kMuch, 0.0}},
    kMaterialBand,
    kHoleBand,
};

/// Measures ClearanceBand: one ray down through the middle of each cell, to the ground. Low
/// vegetation is neither ground nor above it. No value where nothing is above the ground, and where
/// what is there stands on it or is thicker than kThickest_m: a building, a trunk.
class ClearanceEvaluator final : public CellEvaluator {
public:
    /// Of a deck.
    static constexpr double kThickest_m = 5;

    explicit ClearanceEvaluator(const shade::View& view) noexcept : m_view(view) {}

    [[nodiscard]] std::size_t wave_pixels(std::size_t rays) const noexcept override { return rays; }
    // While the ray is on its way, the bands have the bottom and the material of the lowest thing
    // above it: level-0 voxels instead of metres.
    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override {
        if (ray.depth == 0)
            sum.bands = no_values(false);
        const walk::Hit& hit = ray.hit;
        const double edge_m = det::exp2_int(hit.level) * m_view.voxel_m;
        // Directly below an opaque voxel it is the inside of the same thing, of which boxes know
        // nothing, or what that stands on.
        const bool is_inside = hit.t == 0 && !voxel::see_through(ray.medium);
        const bool is_thick = (ray.depth + 1) * edge_m > kThickest_m || ray.depth == UINT8_MAX;
        if (ray.end != walk::WalkEnd::kHit || hit.hole || (is_inside && is_thick)) {
            sum.bands = no_values(is_hole(ray));
            return;
        }
        float& height = at(sum.bands, ClearanceBand::kHeight);
        if (!is_inside && is_ground(hit.attr.material)) {
            if (height != core::kNoData)
                height = static_cast<float>((static_cast<double>(height) - find_top(hit)) *
                                            m_view.voxel_m);
            return;
        }
        walk::TracedRay& on = next.emplace_back(below(ray));
        if (is_inside)
            on.depth = static_cast<std::uint8_t>(ray.depth + 1);
        if (hit.attr.material == voxel::Material::kLowVegetation)
            return;
        height = static_cast<float>(on.ray.origin.y);
        if (!is_inside)
            at(sum.bands, ClearanceBand::kMaterial) = static_cast<float>(hit.attr.material);
    }

private:
    const shade::View& m_view;
};

}  // namespace

template <>
constexpr Analysis kAnalysis<AnalysisKind::kClearance>{kClearanceBands, make<ClearanceEvaluator>};
template const Analysis& find_analysis<AnalysisKind::kClearance>() noexcept;

}  // namespace terravox::analyse
