#pragma once

#include "raytracer/scene/camera.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox {

/// A camera that circles a point: what dragging, scrolling and the keys of the preview move.
struct Orbit {
    Vec3 target;            ///< level-0 voxels
    double distance = 100;  ///< voxels
    double azimuth_deg = 225, down_deg = 35;  ///< where the camera stands, as Scene::Camera

    /// The orbit that shows what `camera` shows, around the point where its middle ray meets the height of `ground_y`.
    static Orbit from(const Camera& camera, double ground_y);
    /// Writes position and target into a scene, in voxels.
    void apply(Scene& scene) const;
    /// Moves the target along the ground, in units of the camera's distance: right and forward as seen.
    void pan(double right, double forward) noexcept;
    void turn(double azimuth_deg, double down_deg) noexcept;
    void zoom(double factor) noexcept;
};

}  // namespace terravox
