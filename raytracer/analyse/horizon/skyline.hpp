#pragma once

#include <cstddef>
#include <vector>

#include "raytracer/analyse/solar/far_horizon.hpp"

namespace terravox::analyse {

/// The tops of a line of terrain that some slope of rays needs: the upper left part of its convex
/// hull, from the first place to the highest one. Built from the near end to the far end.
class Skyline {
public:
    /// Adds a place.
    /// @param distance_m above that of the place before
    /// @param height_m above the sea, lowered by the Earth's curvature
    void add(double distance_m, double height_m);
    /// Height of the highest place so far; below all heights where there is none.
    [[nodiscard]] double highest_m() const noexcept;
    /// The tops in whole metres, the farthest one last. Left out are those that lift the line by
    /// less than half a metre, and those that lift it least where there are more than
    /// FarHorizon::kMaxTops.
    [[nodiscard]] solar::FarHorizon::Tops tops() const;

private:
    struct Place {
        double distance_m = 0;
        double height_m = 0;
    };
    /// How far a place is above the straight line between two others.
    [[nodiscard]] static double lift(const Place& before, const Place& at, const Place& after);

    std::vector<Place> m_places;
};

}  // namespace terravox::analyse
