#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "voxelserver/data/sunlight/flight_light.hpp"
#include "voxelserver/data/sunlight/scene.hpp"

/// Exposure, black point and white balance of a photograph, from materials that the points tell
/// apart and whose albedo differs little from place to place.
namespace terravox::sunlight {

/// Materials of known albedo.
enum class Known : std::uint8_t {
    kAsphalt,  ///< by class, else by how little light its echoes return, else dark grey ground
    kLeaves,   ///< the green of crowns, shrubs and lawns
    kTiles,    ///< pitched roofs that are redder than asphalt
};
inline constexpr std::size_t kKnown = 3;

/// What a photograph shows of a material in the sun.
struct Sighting {
    Light albedo{};           ///< medians, by the light that was measured for the photograph
    std::uint32_t cells = 0;  ///< 0: not seen, then `albedo` is black
};

/// What exposure is found from.
struct Evidence {
    std::array<Sighting, kKnown> seen;
    /// What 0.3 % of all cells are darker than, its light not divided out.
    Light darkest{};
    std::uint32_t cells = 0;  ///< photographed
    [[nodiscard]] const Sighting& of(Known material) const noexcept {
        return seen[static_cast<std::size_t>(material)];
    }
};

/// @param scenes parts of one photograph, without gaps (fill_gaps), with covers where points tell
/// @param light measure_light() of these scenes
[[nodiscard]] Evidence find_evidence(std::span<const Scene> scenes, const FlightLight& light);

/// The evidence of all photographs of a flight: medians, in which each counts by its cells.
/// @param photographs not empty; the result does not depend on their order
[[nodiscard]] Evidence pooled(std::span<const Evidence> photographs);

/// What albedo is corrected by: the black point is taken off, the rest multiplied.
struct Exposure {
    Light black{};
    Light gain{1, 1, 1};
    friend bool operator==(const Exposure&, const Exposure&) = default;
};

/// Changes nothing while the known materials are, by the verdict of most, as bright and as grey as
/// they are in nature. Else they become so. At least two materials must be seen.
[[nodiscard]] Exposure find_exposure(const Evidence& evidence);

/// A light by which albedo comes out corrected. The same, bit for bit, where nothing is to change.
[[nodiscard]] FlightLight exposed(const FlightLight& light, const Exposure& exposure);

}  // namespace terravox::sunlight
