#include "raytracer/analyse/evaluators/analysis.hpp"

#include <algorithm>
#include <array>
#include <iterator>
#include <utility>

#include "common/voxel/analysis.hpp"
#include "raytracer/analyse/solar/place_and_clock.hpp"

namespace terravox::analyse {
namespace {

using FindAnalysis = const Analysis& (*)() noexcept;

template <std::size_t... rows>
constexpr auto list_rows(std::index_sequence<rows...>) noexcept {
    return std::array<FindAnalysis, sizeof...(rows)>{
        &find_analysis<voxel::kAnalyses[rows].kind>...};
}

}  // namespace

/// A picture has no bands, and its light is gathered by another evaluator.
template <>
const Analysis& find_analysis<core::AnalysisKind::kNone>() noexcept {
    static constexpr Analysis kPicture;
    return kPicture;
}

const Analysis& find_analysis(core::AnalysisKind kind) noexcept {
    static constexpr auto kTable =
        list_rows(std::make_index_sequence<std::size(voxel::kAnalyses)>());
    return kTable[static_cast<std::size_t>(&voxel::find_terms(kind) - voxel::kAnalyses)]();
}

std::size_t count_measured(std::span<const RasterBand> bands) noexcept {
    return static_cast<std::size_t>(std::count_if(
        bands.begin(), bands.end(), [](const RasterBand& band) { return !band.is_derived; }));
}

std::size_t find_plane(std::span<const RasterBand> bands, std::string_view name) noexcept {
    if (name == kHoleBand.name)
        return 0;
    const auto end = std::find_if(bands.begin(), bands.end(),
                                  [&](const RasterBand& band) { return band.name == name; });
    return 1 + count_measured({bands.begin(), end});
}

std::shared_ptr<const shade::Measuring> measure(const scene::Scene& scene,
                                                const voxel::WorldInfo& world) {
    const scene::Scene::Analysis& asked = scene.analysis;
    const Analysis& analysis = find_analysis(asked.kind);
    const auto out = std::make_shared<Sunlight>();
    const auto found = solar::find_place(scene, world.centre);
    const geo::MapPlace* const place = found ? &*found : nullptr;
    const double height_m = (world.bounds.min[1] + world.bounds.max[1]) / 2.0 * world.voxel_m;
    if (analysis.sun == SunUse::kWay)
        out->sun_way = solar::make_sun_way(scene, place);
    if (analysis.sun == SunUse::kEnergy)
        out->energy = solar::make_energy(scene, place, height_m);
    out->horizon = solar::parse_far_horizon(asked.horizon, world.voxel_m);
    if (analysis.make == nullptr)
        return nullptr;
    const bool is_low =
        analysis.sky == SkyUse::kFromWalls ||
        (analysis.sky == SkyUse::kFromCells && asked.surface == core::AnalysisSurface::kGround);
    if (is_low && !asked.thin_blocks)
        out->thin_things = walk::ThinThings::kPass;
    out->bands = count_measured(analysis.bands);
    out->make_evaluator = [&analysis](const shade::View& view) {
        return analysis.make(view, static_cast<const Sunlight&>(*view.measuring));
    };
    return out;
}

}  // namespace terravox::analyse
