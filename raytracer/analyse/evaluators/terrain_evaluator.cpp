#include <cmath>

#include "raytracer/analyse/evaluators/cell_evaluator.hpp"

namespace terravox::analyse {
namespace {

float to_byte(float linear) noexcept {
    return std::floor(voxel::linear_to_srgb(linear) * 255 + 0.5F);
}

/// What rays measure for a cell, one float for each. The numbers are those of a tile's planes.
enum class TerrainBand : std::uint8_t {
    kHole,
    kSurface,  ///< top of the highest voxel, metres
    kGround,   ///< top of the ground, metres; kNoData where it is covered
    kClass,    ///< of the survey, of the highest voxel
    kMaterial,
    kRed,  ///< sRGB, 0 to 255
    kGreen,
    kBlue,
};

constexpr RasterBand kTerrainBands[] = {
    {"dsm", "m", {"Height of the surface", Ramp::kHeights}},
    {"dtm", "m", {"Height of the ground", Ramp::kHeights}},
    {"ndsm", "m", {"Height above the ground", Ramp::kMuch, 0.0}, kDerived},
    {"slope", "degree", kSlopeBand.style, kDerived},
    {"aspect", "degree", kAspectBand.style, kDerived},
    {"hillshade", "", {"Hillshade", Ramp::kGrey, 0.0, 255.0}, kDerived},
    kClassBand,
    kMaterialBand,
    {"red"},
    {"green"},
    {"blue"},
    {"dtm_source", "", {}, kDerived},
    kHoleBand,
};

/// Measures TerrainBand: one ray down through the middle of each cell, and on to the ground.
class TerrainEvaluator final : public CellEvaluator {
public:
    explicit TerrainEvaluator(const shade::View& view) noexcept : m_view(view) {}

    [[nodiscard]] std::size_t wave_pixels(std::size_t rays) const noexcept override { return rays; }
    void shade(const walk::TracedRay& ray, shade::SampleSum& sum,
               std::vector<walk::TracedRay>& next) const override {
        const bool is_first = ray.depth == 0;
        if (is_first)
            sum.bands = no_values(false);
        if (ray.end != walk::WalkEnd::kHit)
            return;
        if (ray.hit.hole) {
            sum.bands = no_values(true);
            return;
        }
        if (is_first)
            note_surface(ray.hit, sum.bands);
        switch (descent_at(ray)) {
            case Descent::kGround:
                at(sum.bands, TerrainBand::kGround) =
                    static_cast<float>(find_top(ray.hit) * m_view.voxel_m);
                break;
            case Descent::kCovered: break;
            case Descent::kContinues: next.push_back(below(ray)); break;
        }
    }

private:
    void note_surface(const walk::Hit& hit, core::Bands& bands) const noexcept {
        at(bands, TerrainBand::kSurface) = static_cast<float>(find_top(hit) * m_view.voxel_m);
        at(bands, TerrainBand::kClass) = hit.attr.source_class;
        at(bands, TerrainBand::kMaterial) = static_cast<float>(hit.attr.material);
        if (hit.attr.has_colour()) {
            at(bands, TerrainBand::kRed) = hit.attr.colour.r;
            at(bands, TerrainBand::kGreen) = hit.attr.colour.g;
            at(bands, TerrainBand::kBlue) = hit.attr.colour.b;
            return;
        }
        const voxel::Colour colour = m_view.materials->appearance(hit.attr.material).colour;
        at(bands, TerrainBand::kRed) = to_byte(colour.r);
        at(bands, TerrainBand::kGreen) = to_byte(colour.g);
        at(bands, TerrainBand::kBlue) = to_byte(colour.b);
    }
    const shade::View& m_view;
};

}  // namespace

template <>
constexpr Analysis kAnalysis<AnalysisKind::kTerrain>{kTerrainBands, make<TerrainEvaluator>};
template const Analysis& find_analysis<AnalysisKind::kTerrain>() noexcept;

}  // namespace terravox::analyse
