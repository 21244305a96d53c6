#pragma once

#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/analyse/observer_placing.hpp"

namespace terravox::commands {

/// The forms of an observer, for help and messages.
inline constexpr const char* kObserverForms =
    "E,N,H (height H), E,N,+H (H above the roof, crown or ground there), or E,N,H,above-ground, "
    "metres; E and N in the world's CRS, x and z in voxels where it has none";

/// Reads an observer.
/// @param text one of kObserverForms
/// @throws UsageError for any other text
[[nodiscard]] analyse::Observer observer_of(const std::string& text, const voxel::WorldInfo& world);

/// @throws UsageError also for none, and for more than a scene holds
[[nodiscard]] std::vector<analyse::Observer> observers_of(const std::vector<std::string>& texts,
                                                          const voxel::WorldInfo& world);

}  // namespace terravox::commands
