#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "voxelserver/data/sunlight/light_levels.hpp"
#include "voxelserver/data/sunlight/sun_finder.hpp"

namespace terravox::voxelize {

/// The light of one image, and how it was found.
struct PhotoLight {
    sunlight::FlightLight light;
    sunlight::SunEstimate estimate;  ///< the best one, whether or not it is certain
};

/// For storage.
[[nodiscard]] std::string to_bytes(const PhotoLight& light);
/// @param bytes from any source
/// @return nullopt for bytes of another version, and for values that no search finds
[[nodiscard]] std::optional<PhotoLight> photo_light_of(std::string_view bytes);

}  // namespace terravox::voxelize
