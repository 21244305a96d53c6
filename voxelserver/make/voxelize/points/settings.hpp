#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/voxel/world.hpp"

namespace terravox::voxelize {

/// Which steps run, and how: config/voxelize.toml states units and reasons, and
/// docs/formats/voxelization-settings.md the ranges as well. Results depend on every field.
struct Settings {
    struct Points {
        bool drop_withheld = true;
        bool drop_overlap = false;
        bool drop_isolated = true;
    } points;
    struct Steps {
        bool water_equalization = true;
        bool water_deepening = true;
        bool bridges = true;
        bool ground_fill = true;
        bool building_fill = true;
        bool vegetation = true;
        bool colour_variation = true;
        bool specialization = true;
        bool material_guesses = true;
        bool neighbourhood_filters = true;
    } steps;  ///< switch_steps() knows their names
    struct Buildings {
        double storey_m = 2.4;      ///< an open space beneath a roof is higher than this
        double steep_roof_m = 3.0;  ///< a greater drop between columns of a roof is a wall
    } buildings;
    struct Bridges {
        double thickness_m = 1.0;
        bool recognise = true;       ///< finds decks without a bridge class (bridges.hpp)
        double widest_m = 15.0;      ///< across such a deck
        double min_drop_m = 1.2;     ///< at both of its edges
        double above_water_m = 1.4;  ///< of such a deck, at least
        double above_land_m = 2.5;   ///< the same, where there is no water near
    } bridges;
    struct Ground {
        double soil_m = 2.5;  ///< above the rock
        /// Where the ground drops by more than this to the next column there is no soil.
        double cliff_m = 3.0;
        double depth_m = 10;  ///< of rock below the lowest ground: the model's base
    } ground;
    struct Vegetation {
        double low_m = 1.0, medium_m = 3.0;  ///< tops of the tiers where the source has none
        double canopy_gap_m = 3.0;           ///< foliage between two returns of a crown
        double trunk_from_m = 3.0;           ///< plants at least this high stand on a trunk
        double clutter_m = 0.5;  ///< unclassified objects lower than this are ground roughness
    } vegetation;
    struct Water {
        bool from_class = true;
        bool from_orthophoto = true;
        bool from_voids = true;
        double slope = 0.3;  ///< metres of depth for each metre from the shore
        double min_depth_m = 0.6;
        double max_depth_m = 8;
    } water;
    struct Orthophoto {
        bool albedo = true;  ///< sun, shadow and sky are taken out of its colours (PhotoLights)
    } orthophoto;
    /// Brightness is relative to bright ground (BrightnessScale).
    struct MaterialGuesses {
        double asphalt_below = 0.38;  ///< darker ground is a road
        double bare_below = 0.72;     ///< darker ground is bare; all other is grass
        double flat_slope = 0.15;     ///< a roof column is flat where it rises less in one column
        double flat_share = 0.6;      ///< of a roof's columns, for the roof to be flat
        double tiles_from = 0.6;      ///< a darker steep roof is of slate or metal
    } material_guesses;
    std::string palette = "default";  ///< id in config/palettes, or a file
    std::string tints = "auto";       ///< id in config/tints, a file, or kAnyTints (tints.hpp)
};

/// Fingerprint of all fields but the palette and the tints, of which the values count
/// (input_fingerprints.hpp).
[[nodiscard]] voxel::Fingerprint to_fingerprint(const Settings& settings);

/// Reads a settings file over the defaults, and applies the step switches to it.
/// @param file empty = config/voxelize.toml
/// @param steps see switch_steps(); empty = as in the file
/// @param photo "albedo" or "raw", over orthophoto.albedo; empty = as in the file
/// @throws UsageError for a missing file or an unknown or impossible value, naming field, value and
/// allowed range
[[nodiscard]] Settings load_settings(const std::filesystem::path& file, std::string_view steps = {},
                                     std::string_view photo = {});

/// The name of a step of voxelization, and the setting that switches it on and off.
struct StepSwitch {
    std::string_view name;                 ///< lower case, words with spaces, as timings show it
    std::string_view doc;                  ///< what it does: one sentence without a full stop
    bool Settings::Steps::* on = nullptr;  ///< nullptr: the step always runs
};

inline constexpr StepSwitch kWaterEqualization{"water equalization",
                                               "gives a lake one level and a river a falling one",
                                               &Settings::Steps::water_equalization};
inline constexpr StepSwitch kWaterDeepening{"water deepening",
                                            "lets the bed of water fall away from the shore",
                                            &Settings::Steps::water_deepening};
inline constexpr StepSwitch kBridges{
    "bridges", "makes decks of bridges: without holes, open beneath", &Settings::Steps::bridges};
inline constexpr StepSwitch kGroundFill{
    "ground fill",
    "interpolates terrain between ground points, also under buildings, not under water",
    &Settings::Steps::ground_fill};
inline constexpr StepSwitch kBuildingFill{"building fill",
                                          "closes roofs, and finds what is open beneath them",
                                          &Settings::Steps::building_fill};
inline constexpr StepSwitch kVegetation{"vegetation", "makes closed crowns that stand on trunks",
                                        &Settings::Steps::vegetation};
inline constexpr StepSwitch kColourVariation{
    "colour variation", "gives roofs, walls and crowns of unknown colour one by building and tree",
    &Settings::Steps::colour_variation};
inline constexpr StepSwitch kSpecialization{
    "specialization", "takes materials from the colours of orthophotos and points",
    &Settings::Steps::specialization};
inline constexpr StepSwitch kNeighbourhoodFilters{
    "neighbourhood filters", "replaces stray materials by those of their neighbours",
    &Settings::Steps::neighbourhood_filters};

inline constexpr StepSwitch kMaterialGuesses{
    "material guesses",
    "takes materials from intensities and the shape of roofs where no colour is known",
    &Settings::Steps::material_guesses};

/// All steps that can be switched off, in the order in which they run.
inline constexpr std::array kStepSwitches{
    kWaterEqualization, kWaterDeepening,  kBridges,        kGroundFill,           kBuildingFill,
    kVegetation,        kColourVariation, kSpecialization, kNeighbourhoodFilters, kMaterialGuesses};

/// The name with `_` for spaces: the step's key in [steps] of a settings file, and in `--steps`.
[[nodiscard]] std::string to_key(const StepSwitch& step);

/// Switches steps according to the comma-separated words of `--steps`: `all`, `none`, or the key of
/// a step, which switches it on, or off with `-` before it. Where the first word is the key of a
/// step, only the named steps run. An empty text changes nothing.
/// @throws UsageError for any other word, listing all that are allowed
void switch_steps(std::string_view text, Settings::Steps& steps);

/// The text of `--steps` in `--help`: one line for each step, with a line before them.
[[nodiscard]] std::string steps_help();

}  // namespace terravox::voxelize
