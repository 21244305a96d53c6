#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include "common/voxel/analysis.hpp"

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

// The kinds of analyses are of all programs.
using voxel::AnalysisKind;
inline constexpr auto kAnalysisKinds = [] {
    std::array<Word<AnalysisKind>, std::size(voxel::kAnalyses)> out{};
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = {voxel::kAnalyses[i].kind, voxel::kAnalyses[i].name};
    return out;
}();
constexpr std::span<const Word<AnalysisKind>> list_words(AnalysisKind) noexcept {
    return kAnalysisKinds;
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
