#pragma once

#include "raytracer/scene/camera.hpp"
#include "raytracer/scene/scene.hpp"

namespace terravox::preview {

/// Where a person stands in a world, and the point that they look at: what mouse, keys and gamepad
/// move. Level-0 voxels.
struct Viewpoint {
    core::Vec3 position, target;

    /// What a camera shows, with the point where its middle ray meets the height `ground_y`.
    [[nodiscard]] static Viewpoint of(const scene::Camera& camera, double ground_y);
    /// Into the fields of a scene: in the world's CRS, in voxels where it has none, rounded to
    /// millimetres.
    void apply(scene::Scene& scene, const voxel::WorldInfo& world) const;

    [[nodiscard]] double distance() const noexcept { return core::length(target - position); }
    [[nodiscard]] double heading_deg()
        const noexcept;  ///< of the line of sight, clockwise from north, [0, 360)
    [[nodiscard]] double down_deg() const noexcept;  ///< how steeply it goes down, [-90, 90]

    /// Around the target: to the right, and up. Never over the top.
    void orbit(double right_deg, double up_deg) noexcept;
    /// The head turns: to the right, and down.
    void look(double right_deg, double down_deg) noexcept;
    /// Along the ground as seen, and upwards, voxels.
    void walk(double right, double up, double forward) noexcept;
    /// Along the line of sight and across it, voxels.
    void fly(double right, double up, double forward) noexcept;
    /// Towards the target, which stays. @param factor of the distance
    void approach(double factor) noexcept;
    /// The target moves there, and the person with it.
    void go_to(core::Vec3 point) noexcept;
    /// The person stays, and looks there; from then on it is what they circle.
    void face(core::Vec3 point) noexcept;

    static constexpr double kNearest = 2, kFarthest = 1e6;  ///< of the target, voxels
    friend bool operator==(const Viewpoint&, const Viewpoint&) = default;

private:
    void set_direction(double heading_deg, double down_deg, bool target_stays) noexcept;
};

/// Where a camera shows a point, pixels from the upper left corner. @return nullopt behind it, and
/// for panoramas and fisheyes
[[nodiscard]] std::optional<std::array<double, 2>> pixel_of(const scene::Camera& camera,
                                                            core::Vec3 point, int width_px,
                                                            int height_px) noexcept;

}  // namespace terravox::preview
