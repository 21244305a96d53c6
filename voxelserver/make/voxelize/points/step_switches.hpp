#pragma once

#include <array>
#include <string>
#include <string_view>

#include "voxelserver/make/voxelize/points/settings.hpp"

namespace terravox::voxelize {

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
[[nodiscard]] std::string key_of(const StepSwitch& step);

/// Switches steps according to the comma-separated words of `--steps`: `all`, `none`, or the key of
/// a step, which switches it on, or off with `-` before it. Where the first word is the key of a
/// step, only the named steps run. An empty text changes nothing.
/// @throws UsageError for any other word, listing all that are allowed
void switch_steps(std::string_view text, Settings::Steps& steps);

/// The text of `--steps` in `--help`: one line for each step, with a line before them.
[[nodiscard]] std::string steps_help();

}  // namespace terravox::voxelize
