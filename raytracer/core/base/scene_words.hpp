#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace terravox::core {

// The words that fields of a scene may hold: text in files, on the command line and in the window,
// enumerators everywhere else. To add a word, add an enumerator and a row of its table.

/// An enumerator and the word that stands for it in a scene.
template <class Enum>
struct Word {
    Enum value;
    std::string_view text;
};

/// How directions or points of space are projected into the picture.
enum class CameraProjection : std::uint8_t {
    kPerspective,
    kOrthographic,
    kIsometric,  ///< orthographic, from a direction that shows three sides alike
    kPanorama,
    kFisheye,
};
inline constexpr Word<CameraProjection> kCameraProjections[] = {
    {CameraProjection::kPerspective, "perspective"},
    {CameraProjection::kOrthographic, "orthographic"},
    {CameraProjection::kIsometric, "isometric"},
    {CameraProjection::kPanorama, "panorama"},
    {CameraProjection::kFisheye, "fisheye"},
};
constexpr std::span<const Word<CameraProjection>> list_words(CameraProjection) noexcept {
    return kCameraProjections;
}

/// Whether all rays of a picture have one direction.
[[nodiscard]] constexpr bool is_parallel(CameraProjection projection) noexcept {
    return projection == CameraProjection::kOrthographic ||
           projection == CameraProjection::kIsometric;
}

/// Coordinates in which a scene gives its points.
enum class CoordinateSpace : std::uint8_t {
    kCrs,     ///< easting, northing, height in metres
    kLatLon,  ///< latitude and longitude in degrees, height in metres
    kVoxel,   ///< x, y, z in voxels of level 0
};
inline constexpr Word<CoordinateSpace> kCoordinateSpaces[] = {
    {CoordinateSpace::kCrs, "crs"},
    {CoordinateSpace::kLatLon, "latlon"},
    {CoordinateSpace::kVoxel, "voxel"},
};
constexpr std::span<const Word<CoordinateSpace>> list_words(CoordinateSpace) noexcept {
    return kCoordinateSpaces;
}

/// Model that the light of the sky comes from.
enum class SkyModel : std::uint8_t { kAtmosphere, kUniform };
inline constexpr Word<SkyModel> kSkyModels[] = {
    {SkyModel::kAtmosphere, "atmosphere"},
    {SkyModel::kUniform, "uniform"},
};
constexpr std::span<const Word<SkyModel>> list_words(SkyModel) noexcept {
    return kSkyModels;
}

/// Mapping from linear light to the values of an 8-bit picture (raytracer/core/output/develop.hpp).
enum class ToneCurve : std::uint8_t { kPhotographic, kFilmic, kAgx, kLinear };
inline constexpr Word<ToneCurve> kToneCurves[] = {
    {ToneCurve::kPhotographic, "photographic"},
    {ToneCurve::kFilmic, "filmic"},
    {ToneCurve::kAgx, "agx"},
    {ToneCurve::kLinear, "linear"},
};
constexpr std::span<const Word<ToneCurve>> list_words(ToneCurve) noexcept {
    return kToneCurves;
}

/// Layers that an EXR file contains.
enum class PictureLayers : std::uint8_t { kBeauty, kAll };
inline constexpr Word<PictureLayers> kPictureLayers[] = {
    {PictureLayers::kBeauty, "beauty"},
    {PictureLayers::kAll, "all"},
};
constexpr std::span<const Word<PictureLayers>> list_words(PictureLayers) noexcept {
    return kPictureLayers;
}

/// Sample format of TIFF files.
enum class TiffSamples : std::uint8_t {
    kAuto,  ///< bytes for maps (orthographic, straight down), floats otherwise
    kByte,
    kFloat,
};
inline constexpr Word<TiffSamples> kTiffSamples[] = {
    {TiffSamples::kAuto, "auto"},
    {TiffSamples::kByte, "byte"},
    {TiffSamples::kFloat, "float"},
};
constexpr std::span<const Word<TiffSamples>> list_words(TiffSamples) noexcept {
    return kTiffSamples;
}

/// Which light transport is computed.
enum class Integrator : std::uint8_t {
    kDirect,  ///< sun, sky, mirrors, water
    kPath,    ///< all light, with bounces
};
inline constexpr Word<Integrator> kIntegrators[] = {
    {Integrator::kDirect, "direct"},
    {Integrator::kPath, "path"},
};
constexpr std::span<const Word<Integrator>> list_words(Integrator) noexcept {
    return kIntegrators;
}

/// What a pixel is: light, or measured values of a cell of a raster (docs/adr/0029).
enum class AnalysisKind : std::uint8_t {
    kNone,       ///< a picture
    kTerrain,    ///< heights, classes, materials, colours
    kSky,        ///< how much of the sky is seen
    kSun,        ///< hours of direct sun on a day
    kSunPeriod,  ///< hours of direct sun in a period
    kSunMonths,  ///< the same, and by month
    kShadow,     ///< whether the sun shines at an instant
    kSunView,    ///< hours of direct sun on a day, as a camera sees them: pixels, no bands
    kEnergy,     ///< energy of the sun and of the sky
    kFacade,     ///< the same, on the walls of one side and storey
    kSight,      ///< what observers see
};
inline constexpr Word<AnalysisKind> kAnalysisKinds[] = {
    {AnalysisKind::kNone, "none"},
    {AnalysisKind::kTerrain, "terrain"},
    {AnalysisKind::kSky, "sky"},
    {AnalysisKind::kSun, "sun"},
    {AnalysisKind::kSunPeriod, "sun-period"},
    {AnalysisKind::kSunMonths, "sun-months"},
    {AnalysisKind::kShadow, "shadow"},
    {AnalysisKind::kSunView, "sun-view"},
    {AnalysisKind::kEnergy, "energy"},
    {AnalysisKind::kFacade, "facade"},
    {AnalysisKind::kSight, "sight"},
};
constexpr std::span<const Word<AnalysisKind>> list_words(AnalysisKind) noexcept {
    return kAnalysisKinds;
}

/// Whether an analysis sends rays towards the sun.
[[nodiscard]] constexpr bool needs_sun_way(AnalysisKind kind) noexcept {
    return kind == AnalysisKind::kSun || kind == AnalysisKind::kSunPeriod ||
           kind == AnalysisKind::kSunMonths || kind == AnalysisKind::kShadow ||
           kind == AnalysisKind::kSunView;
}

/// Whether an analysis sums up the light of a period.
[[nodiscard]] constexpr bool needs_light(AnalysisKind kind) noexcept {
    return kind == AnalysisKind::kEnergy || kind == AnalysisKind::kFacade;
}

/// Where the outside of a wall is, on the map.
enum class WallSide : std::uint8_t { kNorth, kEast, kSouth, kWest };
inline constexpr Word<WallSide> kWallSides[] = {
    {WallSide::kNorth, "north"},
    {WallSide::kEast, "east"},
    {WallSide::kSouth, "south"},
    {WallSide::kWest, "west"},
};
constexpr std::span<const Word<WallSide>> list_words(WallSide) noexcept {
    return kWallSides;
}

/// Where in a cell an analysis measures.
enum class AnalysisSurface : std::uint8_t {
    kTop,     ///< on the highest voxel
    kGround,  ///< on the ground or low vegetation, below crowns, wires and decks
};
inline constexpr Word<AnalysisSurface> kAnalysisSurfaces[] = {
    {AnalysisSurface::kTop, "top"},
    {AnalysisSurface::kGround, "ground"},
};
constexpr std::span<const Word<AnalysisSurface>> list_words(AnalysisSurface) noexcept {
    return kAnalysisSurfaces;
}

/// Order in which tiles are traced (raytracer/core/tiles/tile_plan.hpp).
enum class TileOrder : std::uint8_t { kSpiral, kVertical, kVerticalSplit, kHilbert, kRows };
inline constexpr Word<TileOrder> kTileOrders[] = {
    {TileOrder::kSpiral, "spiral"},
    {TileOrder::kVertical, "vertical"},
    {TileOrder::kVerticalSplit, "vertical-split"},
    {TileOrder::kHilbert, "hilbert"},
    {TileOrder::kRows, "rows"},
};
constexpr std::span<const Word<TileOrder>> list_words(TileOrder) noexcept {
    return kTileOrders;
}

/// The colour of voxels that have a true one, from orthophotos or from the points.
enum class VoxelColour : std::uint8_t { kMaterial, kTrue, kMix };
inline constexpr Word<VoxelColour> kVoxelColours[] = {
    {VoxelColour::kMaterial, "material"},
    {VoxelColour::kTrue, "true"},
    {VoxelColour::kMix, "mix"},
};
constexpr std::span<const Word<VoxelColour>> list_words(VoxelColour) noexcept {
    return kVoxelColours;
}

/// An enumeration with a table of words.
template <class Enum>
concept WordEnum = requires(Enum value) { list_words(value); };

/// @return the word of a value; empty if the table has no row for it
template <WordEnum Enum>
[[nodiscard]] constexpr std::string_view to_word(Enum value) noexcept {
    for (const Word<Enum>& word : list_words(value))
        if (word.value == value)
            return word.text;
    return {};
}

/// @return nullopt for a word that is not in the table
template <WordEnum Enum>
[[nodiscard]] constexpr std::optional<Enum> from_word(std::string_view text) noexcept {
    for (const Word<Enum>& word : list_words(Enum{}))
        if (word.text == text)
            return word.value;
    return std::nullopt;
}

}  // namespace terravox::core
