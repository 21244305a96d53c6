#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <type_traits>

#include "common/voxel/world.hpp"
#include "raytracer/analyse/solar/energy.hpp"
#include "raytracer/analyse/solar/far_horizon.hpp"
#include "raytracer/analyse/solar/sun_way.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "raytracer/core/shade/shading.hpp"

namespace terravox::analyse {

/// How values become colours.
enum class Ramp : std::uint8_t {
    kHeights,    ///< green lowland to white summits
    kMuch,       ///< dark blue to yellow: shares, angles
    kWarm,       ///< black to light yellow: sun and energy
    kAround,     ///< directions: 0 and 360 degrees have the same colour
    kGrey,       ///< hillshade
    kClasses,    ///< LiDAR classes, a colour each
    kMaterials,  ///< materials, a colour each
};

[[nodiscard]] constexpr std::string_view name_of_ramp(Ramp ramp) noexcept {
    constexpr std::string_view kNames[] = {"heights", "much",    "warm",     "around",
                                           "grey",    "classes", "materials"};
    return kNames[static_cast<std::size_t>(ramp)];
}

/// How a band is drawn as a map. Rasters carry it for whoever draws them (docs/guide/analyses.md).
struct BandStyle {
    std::string_view title = {};  ///< of its map; empty: it has none, and is in tables only
    Ramp ramp = Ramp::kGrey;
    /// Ends of the scale; nullopt: by the values.
    std::optional<double> low = {};
    std::optional<double> high = {};
    bool is_reported = true;  ///< has a map in reports
    bool is_clock = false;    ///< values are hours of a clock
    /// "0|1": what the values 0 and 1 mean, where there are no others; empty: they are measures.
    std::string_view words = {};
};
inline constexpr bool kNotReported = false;
inline constexpr bool kClock = true;

/// A band of a raster.
struct RasterBand {
    std::string_view name;       ///< also the band's description in the file
    std::string_view unit = {};  ///< empty: none
    BandStyle style = {};
    bool is_derived = false;  ///< computed from other bands of the raster
};
inline constexpr bool kDerived = true;

// Bands that several analyses have.
inline constexpr RasterBand kClassBand{"class", "", {"LiDAR class", Ramp::kClasses}};
inline constexpr RasterBand kMaterialBand{"material", "", {"Material", Ramp::kMaterials}};
inline constexpr RasterBand kSlopeBand{"slope", "degree", {"Slope", Ramp::kMuch, 0.0}};
inline constexpr RasterBand kAspectBand{"aspect", "degree", {"Aspect", Ramp::kAround, 0.0, 360.0}};
inline constexpr RasterBand kSunHoursBand{
    "sun_hours", "h", {"Hours of direct sun", Ramp::kWarm, 0.0}};
/// The last one of each: 1 where data could not be read.
inline constexpr RasterBand kHoleBand{"hole",
                                      "",
                                      {"Data that could not be read", Ramp::kMuch, 0.0, 1.0,
                                       kNotReported, !kClock, "read|could not be read"}};

/// What the evaluators of a view have in common.
struct Sunlight : shade::Measuring {
    solar::SunWay sun_way;      ///< with SunUse::kWay
    solar::Energy energy;       ///< with SunUse::kEnergy
    solar::FarHorizon horizon;  ///< terrain outside of the data
};

enum class SunUse : std::uint8_t {
    kNone,
    kWay,     ///< rays to where the sun is
    kEnergy,  ///< the light of a period, of sun and sky
};

/// Whether an analysis looks at sun or sky, from where, and so what thin things mean to its rays.
/// What people stand in does not shade them, and voxels make trunks and wires many times as wide:
/// for light on the ground and on facades they are passed, unless the scene says that they block.
/// On the surface that is seen from above, as for tools that know heights only, they always block.
enum class SkyUse : std::uint8_t { kNone, kFromCells, kFromWalls };

/// An analysis: how that is measured which voxel::AnalysisTerms name.
struct Analysis {
    /// In the order of its files, holes last. A tile has holes first, then the measured ones.
    std::span<const RasterBand> bands = {};
    /// What evaluates its rays; nullptr: a picture. The arguments must outlive the result.
    std::unique_ptr<const shade::RayEvaluator> (*make)(const shade::View&,
                                                       const Sunlight&) = nullptr;
    SunUse sun = SunUse::kNone;
    SkyUse sky = SkyUse::kNone;
};

/// For Analysis::make.
template <class Evaluator>
std::unique_ptr<const shade::RayEvaluator> make(const shade::View& view, const Sunlight& sunlight) {
    if constexpr (std::is_constructible_v<Evaluator, const shade::View&, const Sunlight&>)
        return std::make_unique<Evaluator>(view, sunlight);
    else
        return std::make_unique<Evaluator>(view);
}

/// That of one kind. The source that measures it specializes kAnalysis and instantiates this; a
/// program that lacks one is not linked.
template <core::AnalysisKind kind>
[[nodiscard]] const Analysis& find_analysis() noexcept;

[[nodiscard]] const Analysis& find_analysis(core::AnalysisKind kind) noexcept;

/// Number of the measured bands.
[[nodiscard]] std::size_t count_measured(std::span<const RasterBand> bands) noexcept;
/// Which of a pixel's values in a tile is that of a measured band.
[[nodiscard]] std::size_t find_plane(std::span<const RasterBand> bands,
                                     std::string_view name) noexcept;

/// What the scene of an analysis measures, for shade::make_view; of pictures nullptr.
/// @throws UsageError as solar::find_place(), solar::make_sun_way(), solar::make_energy() and
/// solar::parse_far_horizon()
[[nodiscard]] std::shared_ptr<const shade::Measuring> measure(const scene::Scene& scene,
                                                              const voxel::WorldInfo& world);

/// Hours for which the sun is up on the day of a view of kind kSunView; 0 of pictures.
/// @param view made with measure()
[[nodiscard]] inline double day_hours(const shade::View& view) noexcept {
    return view.measuring ? static_cast<const Sunlight&>(*view.measuring).sun_way.hours : 0;
}

}  // namespace terravox::analyse
