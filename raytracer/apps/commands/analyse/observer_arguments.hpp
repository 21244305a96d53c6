#pragma once

#include <string>
#include <vector>

#include "common/voxel/world.hpp"
#include "raytracer/analyse/evaluators/observer_placing.hpp"

namespace terravox::commands {

/// The forms of an observer, for help and messages.
inline constexpr const char* kObserverForms =
    "E,N,H (height H), E,N,+H (H above the roof, crown or ground there), or E,N,H,above-ground, "
    "metres; E and N in the world's CRS, x and z in voxels where it has none";

/// The forms of a file of observers, for help.
inline constexpr const char* kObserverFileForm =
    "GeoJSON file of points and lines that look: at their third coordinate, at 'height' metres "
    "above the ground where a feature has that property, else at 1.6";

/// The observers of a command line.
struct ObserverArguments {
    std::vector<std::string> texts;  ///< each one of kObserverForms
    std::vector<std::string> files;
    double step_m = 10;  ///< between the observers of a line
};

/// Reads an observer.
/// @param text one of kObserverForms
/// @throws UsageError for any other text
[[nodiscard]] analyse::Observer observer_of(const std::string& text, const voxel::WorldInfo& world);

/// @throws UsageError also for none, and for more than a scene holds; Error for a file that cannot
/// be read
[[nodiscard]] std::vector<analyse::Observer> observers_of(const ObserverArguments& args,
                                                          const voxel::WorldInfo& world);

}  // namespace terravox::commands
