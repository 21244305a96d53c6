#pragma once

#include <filesystem>
#include <vector>

#include "voxelserver/survey/photo_light.hpp"

namespace terravox::bench {

/// A synthetic flight: a place, and the light of its photograph.
struct Flight {
    std::uint64_t seed = 7;
    survey::PhotoLight light;
};

/// Twenty flights over twenty places; three in haze, two under clouds, one with both.
[[nodiscard]] std::vector<Flight> photo_flights();

/// How well the light of a flight was found and taken out of its photograph.
struct FlightErrors {
    bool found = false;
    double azimuth_deg = 0;   ///< absolute error
    double altitude_deg = 0;  ///< the same
    /// Root mean squared difference to the albedo, linear, of the photograph and of what was made
    /// of it.
    double raw_rmse = 0;
    double albedo_rmse = 0;
    /// Mean of the logarithm of sun over shadow across edges of shadows on one material, 2 m to
    /// each side: of the photograph and of what was made of it.
    double raw_contrast = 0;
    double albedo_contrast = 0;
};

/// Surveys a square of 512 m with 8 pulses/m2 in `folder`, unless it is there, and takes the light
/// out of its photograph in voxels of 1 m.
[[nodiscard]] FlightErrors measure_flight(const Flight& flight, const std::filesystem::path& folder,
                                          int threads);

}  // namespace terravox::bench
