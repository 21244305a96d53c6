#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "raytracer/core/scene/camera.hpp"

namespace terravox::scene {
namespace {

using util::plain_number_text;

// voxels: beyond that, a ray's positions are coarser than the things it hits
constexpr double kFarthest = 1e9;
constexpr double kMaxFov_deg = 170;

[[noreturn]] void refuse(const std::string& what) {
    throw util::UsageError("place the camera: " + what);
}

void check_range(const char* field, double value, double min, double max, const std::string& of) {
    if (!(value >= min && value <= max))
        refuse(std::string("camera.") + field + " = " + plain_number_text(value) + "; allowed" +
               of + ": " + plain_number_text(min) + " to " + plain_number_text(max));
}

/// A block between two corners, level-0 voxels.
struct Block {
    explicit Block(const voxel::VoxelBounds& b)
        : low{static_cast<double>(b.min[0]), static_cast<double>(b.min[1]),
              static_cast<double>(b.min[2])},
          high{static_cast<double>(b.max[0]), static_cast<double>(b.max[1]),
               static_cast<double>(b.max[2])},
          middle{(b.min[0] + b.max[0]) / 2.0, (b.min[1] + b.max[1]) / 2.0,
                 (b.min[2] + b.max[2]) / 2.0} {}
    [[nodiscard]] core::Vec3 corner(int i) const noexcept {
        return {(i & 1) != 0 ? high.x : low.x, (i & 2) != 0 ? high.y : low.y,
                (i & 4) != 0 ? high.z : low.z};
    }
    core::Vec3 low;
    core::Vec3 high;
    core::Vec3 middle;
};

/// The camera on a given line of sight that sees all eight corners of a block, as near as possible.
/// In camera axes each side of the picture is a plane through the camera; the corner that is
/// farthest out fixes it. The pair of left and right planes gives one distance, top and bottom
/// another; the farther one frames both.
core::Vec3 frame_position(const Block& block, const Axes& axes, double tan_x, double tan_y) {
    constexpr double kBig = 1e30;
    double low_x = kBig;
    double high_x = -kBig;
    double low_y = kBig;
    double high_y = -kBig;
    double nearest = kBig;
    for (int i = 0; i < 8; ++i) {
        const core::Vec3 corner = block.corner(i) - block.middle;
        const double d = core::dot(corner, axes.forward);
        const double x = core::dot(corner, axes.right);
        const double y = core::dot(corner, axes.up);
        // Camera at (cx, cy, -depth): |x - cx| <= tan_x (d + depth).
        low_x = std::min(low_x, x + tan_x * d);
        high_x = std::max(high_x, x - tan_x * d);
        low_y = std::min(low_y, y + tan_y * d);
        high_y = std::max(high_y, y - tan_y * d);
        nearest = std::min(nearest, d);
    }
    const double depth =
        std::max({(high_x - low_x) / (2 * tan_x), (high_y - low_y) / (2 * tan_y), 1 - nearest});
    return block.middle + axes.right * ((high_x + low_x) / 2) + axes.up * ((high_y + low_y) / 2) -
           axes.forward * depth;
}

/// The camera stands at the azimuth, so it looks the other way. North is -z.
core::Vec3 to_forward(double azimuth_deg, double sin_down, double cos_down) {
    const double azimuth = azimuth_deg * trig::kRadPerDeg;
    return {-std::sin(azimuth) * cos_down, -sin_down, std::cos(azimuth) * cos_down};
}

/// One camera on its way from the fields of a scene to a shape.
Projection make_shape(core::CameraProjection projection) noexcept {
    switch (projection) {
        case core::CameraProjection::kPerspective: return Projection::kPerspective;
        case core::CameraProjection::kOrthographic:
        case core::CameraProjection::kIsometric: return Projection::kOrthographic;
        case core::CameraProjection::kPanorama: return Projection::kPanorama;
        case core::CameraProjection::kFisheye: return Projection::kFisheye;
    }
    return Projection::kPerspective;
}

class Placing {
public:
    Placing(const Scene& scene, const voxel::WorldInfo& world, const voxel::VoxelBounds& subject)
        : m_camera(scene.camera),
          m_world(world),
          m_block(subject),
          m_width(scene.output.size_px[0]),
          m_height(scene.output.size_px[1]) {
        m_isometric = m_camera.projection == core::CameraProjection::kIsometric;
        m_shape.projection = make_shape(m_camera.projection);
        m_shape.width_px = m_width;
        m_shape.height_px = m_height;
        m_shape.voxel_m = world.voxel_m;
        check();
        if (m_camera.position)
            m_position = placed("position", *m_camera.position);
        if (m_camera.target)
            m_target = placed("target", *m_camera.target);
        if (m_position && m_target && !(core::length(*m_target - *m_position) > 1e-9))
            refuse("camera.position and camera.target are the same point");
    }

    [[nodiscard]] Camera camera() {
        switch (m_shape.projection) {
            case Projection::kPerspective: return perspective();
            case Projection::kOrthographic: return orthographic();
            case Projection::kPanorama: return panorama();
            case Projection::kFisheye: break;
        }
        return fisheye();
    }

private:
    void check() const {
        const Scene::Camera& c = m_camera;
        const bool parallel = m_shape.projection == Projection::kOrthographic;
        const bool perspective = m_shape.projection == Projection::kPerspective;
        if (c.position.has_value() != c.target.has_value() && !(parallel && c.target))
            refuse(std::string("camera.") + (c.position ? "target" : "position") +
                   " is missing; give both, or none to frame the world");
        if (m_width < 1 || m_height < 1)
            refuse("output.size = " + std::to_string(m_width) + "x" + std::to_string(m_height) +
                   "; allowed: 1x1 and more");
        if (perspective)
            check_range("fov_deg", c.fov_deg, 1, kMaxFov_deg, " for a perspective");
        if (m_shape.projection == Projection::kFisheye)
            check_range("fov_deg", c.fov_deg, 1, 360, " for a fisheye");
        check_range("roll_deg", c.roll_deg, -360, 360, "");
        check_range("azimuth_deg", c.azimuth_deg, -360, 360, "");
        check_range("down_deg", c.down_deg, -90, 90, "");
        check_range("margin", c.margin, 0, 0.45, "");
        check_range("zoom", c.zoom, 0.001, 1000, "");
        if (c.height_m)
            check_range("height_m", *c.height_m, 0.001, 1e7, "");
        if (c.focus_m)
            check_range("focus_m", *c.focus_m, 0.001, 1e7, "");
        check_range("aperture_m", c.aperture_m, 0, 10000, "");
        if (c.aperture_m > 0 && !perspective && !parallel)
            refuse("camera.aperture_m = " + plain_number_text(c.aperture_m) + "; allowed for a " +
                   std::string(core::to_word(c.projection)) + ": 0, it has no lens");
        if (c.roll_deg != 0 && m_shape.projection == Projection::kPanorama)
            refuse("camera.roll_deg = " + plain_number_text(c.roll_deg) +
                   "; allowed for a panorama: 0, it stands upright");
    }

    [[nodiscard]] core::Vec3 placed(const char* field, const std::array<double, 3>& point) const {
        const auto numbers = [&](double a, double b, double c) {
            return std::string("camera.") + field + " = (" + plain_number_text(a) + ", " +
                   plain_number_text(b) + ", " + plain_number_text(c) + ")";
        };
        if (!std::all_of(point.begin(), point.end(), [](double v) { return std::isfinite(v); }))
            refuse(numbers(point[0], point[1], point[2]) + "; allowed: finite numbers");
        const core::Vec3 v = [&] {
            try {
                return to_voxels(point, m_camera.space, m_world);
            } catch (const util::UsageError&) {
                throw;
            } catch (const util::Error&) {
                refuse(numbers(point[0], point[1], point[2]) + " is no place that " + m_world.crs +
                       " can tell; allowed: latitude, longitude and height near the world");
            }
        }();
        for (const double c : {v.x, v.y, v.z})
            if (!(std::abs(c) < kFarthest))
                refuse(numbers(point[0], point[1], point[2]) +
                       " lies beyond 10^9 voxels; allowed: nearer to the middle of its " +
                       std::string(core::to_word(m_camera.space)) + " space");
        return v;
    }

    [[nodiscard]] core::Vec3 framing_forward() const {
        if (m_isometric)
            return to_forward(m_camera.azimuth_deg, std::sqrt(1.0 / 3), std::sqrt(2.0 / 3));
        const double down = m_camera.down_deg * trig::kRadPerDeg;
        return to_forward(m_camera.azimuth_deg, std::sin(down), std::cos(down));
    }

    void look_along(const Axes& axes) {
        m_shape.forward = axes.forward;
        m_shape.right = axes.right;
        m_shape.up = axes.up;
    }

    /// @param sharp distance of the plane of focus where the scene gives none, voxels
    void set_lens(double sharp) {
        m_shape.lens_radius = m_camera.aperture_m / 2 / m_world.voxel_m;
        m_shape.focus =
            m_camera.focus_m ? *m_camera.focus_m / m_world.voxel_m : std::max(sharp, 0.001);
    }

    [[nodiscard]] Camera perspective() {
        const double half = half_of_fov(m_camera.fov_deg);
        if (!m_position) {
            const core::Vec3 forward = framing_forward();
            const double tan_y = half * (1 - 2 * m_camera.margin);
            core::Vec3 position =
                frame_position(m_block, rolled(make_axes(forward), m_camera.roll_deg),
                               tan_y * m_width / m_height, tan_y);
            position = position + forward * (core::dot(m_block.middle - position, forward) *
                                             (1 - 1 / m_camera.zoom));
            set_lens(core::dot(m_block.middle - position, forward));
            m_position = position;
            m_target = position + forward;
        } else
            set_lens(core::length(*m_target - *m_position));
        m_shape.position = *m_position;
        m_shape.half = half;
        look_along(rolled(make_axes(core::normalized(*m_target - *m_position)), m_camera.roll_deg));
        return Camera(m_shape);
    }

    [[nodiscard]] Camera orthographic() {
        core::Vec3 forward = m_position && !m_isometric ? core::normalized(*m_target - *m_position)
                                                        : framing_forward();
        // Straight down exactly, as on a map.
        if (std::abs(forward.x) + std::abs(forward.z) < 1e-9)
            forward = {0, forward.y < 0 ? -1.0 : 1.0, 0};
        const Axes axes = rolled(make_axes(forward), m_camera.roll_deg);
        look_along(axes);
        const core::Vec3 about = m_target ? *m_target : m_block.middle;
        double half_x = 0;
        double half_y = 0;
        double nearest = 1e30;
        for (int i = 0; i < 8; ++i) {
            const core::Vec3 corner = m_block.corner(i) - about;
            half_x = std::max(half_x, std::abs(core::dot(corner, axes.right)));
            half_y = std::max(half_y, std::abs(core::dot(corner, axes.up)));
            nearest = std::min(nearest, core::dot(corner, forward));
        }
        if (m_world.typical_heights) {
            const Block all(m_world.bounds);
            for (int i = 0; i < 8; ++i)
                nearest = std::min(nearest, core::dot(all.corner(i) - about, forward));
        }
        const double fits = std::max({half_y, half_x * m_height / m_width, 0.5}) /
                            (1 - 2 * m_camera.margin) / m_camera.zoom;
        m_shape.half = m_camera.height_m ? *m_camera.height_m / 2 / m_world.voxel_m : fits;
        // Rays start where no voxel of any level sticks out of the world towards the camera, and
        // before what it is about.
        const double start = std::min(
            nearest - 2.0 * static_cast<double>(std::int64_t{1} << (m_world.levels - 1)), -1.0);
        m_shape.position = about + forward * start;
        const bool stands = m_position && !m_isometric;
        set_lens(stands ? core::length(*m_target - *m_position) : -start);
        m_shape.back = stands ? core::dot(*m_position - m_shape.position, forward) : 0;
        return Camera(m_shape);
    }

    [[nodiscard]] Camera panorama() {
        const core::Vec3 sight = m_position ? *m_target - *m_position : framing_forward();
        const double flat = std::sqrt(sight.x * sight.x + sight.z * sight.z);
        // Straight up or down: towards the north.
        const core::Vec3 forward = flat > 1e-9 * core::length(sight)
                                       ? core::Vec3{sight.x / flat, 0, sight.z / flat}
                                       : core::Vec3{0, 0, -1};
        look_along({forward, core::cross(forward, {0, 1, 0}), {0, 1, 0}});
        if (m_position)
            m_shape.position = *m_position;
        else {
            const double width =
                std::max(m_block.high.x - m_block.low.x, m_block.high.z - m_block.low.z);
            m_shape.position = {m_block.middle.x, m_block.high.y + std::max(width / 20, 2.0),
                                m_block.middle.z};
        }
        return Camera(m_shape);
    }

    [[nodiscard]] Camera fisheye() {
        // Wider, and the camera would stand in what it frames.
        constexpr double kMaxFraming_deg = 85;
        m_shape.half = m_camera.fov_deg / 2 * trig::kRadPerDeg;
        const core::Vec3 forward =
            m_position ? core::normalized(*m_target - *m_position) : framing_forward();
        look_along(rolled(make_axes(forward), m_camera.roll_deg));
        const double angle =
            std::min(m_camera.fov_deg / 2 * (1 - 2 * m_camera.margin), kMaxFraming_deg) *
            trig::kRadPerDeg;
        m_shape.position =
            m_position ? *m_position
                       : m_block.middle - forward * (core::length(m_block.high - m_block.middle) /
                                                     std::sin(angle) / m_camera.zoom);
        return Camera(m_shape);
    }

    const Scene::Camera& m_camera;
    const voxel::WorldInfo& m_world;
    Block m_block;
    int m_width;
    int m_height;
    bool m_isometric = false;
    std::optional<core::Vec3> m_position;
    std::optional<core::Vec3> m_target;
    CameraShape m_shape;
};

}  // namespace

core::Vec3 to_voxels(const std::array<double, 3>& p, core::CoordinateSpace space,
                     const voxel::WorldInfo& world) {
    if (space == core::CoordinateSpace::kVoxel)
        return {p[0], p[1], p[2]};
    if (world.crs.empty())
        throw util::UsageError("place the camera: camera.space = '" +
                               std::string(core::to_word(space)) +
                               "', but this world is not georeferenced; allowed: voxel");
    double easting = p[0];
    double northing = p[1];
    if (space == core::CoordinateSpace::kLatLon) {
        if (!(std::abs(p[0]) <= 90))
            refuse("latitude = " + plain_number_text(p[0]) +
                   "; allowed: -90 to 90, and the longitude after it");
        if (!(std::abs(p[1]) <= 360))
            refuse("longitude = " + plain_number_text(p[1]) + "; allowed: -360 to 360");
        easting = p[1];
        northing = p[0];
        geo::Transform(geo::Crs::from_text("EPSG:4326"), geo::Crs::from_wkt(world.crs_wkt))
            .apply({&easting, 1}, {&northing, 1});
    }
    return {easting / world.crs_units_per_voxel, p[2] / world.voxel_m,
            -northing / world.crs_units_per_voxel};
}

Camera make_camera(const Scene& scene, const voxel::WorldInfo& world,
                   const voxel::VoxelBounds& subject) {
    return Placing(scene, world, subject).camera();
}

}  // namespace terravox::scene
