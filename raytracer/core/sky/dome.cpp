#include "raytracer/core/sky/dome.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "raytracer/core/base/random.hpp"

namespace terravox::sky {
namespace {

constexpr int kCells = 24;          // along an edge of each face of the cube around the observer
constexpr double kShare = 0.4;      // of the cells that hold a star
constexpr double kRadius = 0.0011;  // radians
constexpr std::uint64_t kSeed = 0x5741525354415253;

struct Place {
    int face;
    double u, v;  // [-1, 1]
};

Place find_place(core::Vec3 d) noexcept {
    const double ax = std::fabs(d.x);
    const double ay = std::fabs(d.y);
    const double az = std::fabs(d.z);
    if (ay >= ax && ay >= az)
        return {d.y > 0 ? 0 : 1, d.x / ay, d.z / ay};
    if (ax >= az)
        return {d.x > 0 ? 2 : 3, d.y / ax, d.z / ax};
    return {d.z > 0 ? 4 : 5, d.x / az, d.y / az};
}

core::Vec3 to_direction(const Place& p) noexcept {
    const double s = p.face % 2 == 0 ? 1 : -1;
    return core::normalized(p.face < 2   ? core::Vec3{p.u, s, p.v}
                            : p.face < 4 ? core::Vec3{s, p.u, p.v}
                                         : core::Vec3{p.u, p.v, s});
}

int find_cell(double u) noexcept {
    return u > -1 ? std::min(static_cast<int>((std::min(u, 1.0) + 1) / 2 * kCells), kCells - 1) : 0;
}

}  // namespace

voxel::Colour starlight(core::Vec3 d) noexcept {
    const Place at = find_place(d);
    const int i = find_cell(at.u);
    const int j = find_cell(at.v);
    std::uint64_t hash =
        core::hash64(kSeed, static_cast<std::uint64_t>((at.face * kCells + i) * kCells + j));
    const auto next = [&] { return core::unit_from(hash = core::hash64(hash)); };
    if (next() >= kShare)
        return {};
    // A star keeps such a distance from the edge of its cell that it never extends into another
    // cell.
    constexpr double kInside = 0.9;
    const auto inside = [&](int cell) {
        return (cell + 0.5 + kInside * (next() - 0.5)) * 2 / kCells - 1;
    };
    const double u = inside(i);
    const double v = inside(j);
    const core::Vec3 apart = d - to_direction({at.face, u, v});
    const double r2 = core::dot(apart, apart) / (kRadius * kRadius);
    if (!(r2 < 1))
        return {};
    // Ten stars of half the brightness for each one; the few bright ones are what the eye finds
    // patterns in.
    const double rank = 1 - next();
    const double brightness = std::min(12 / std::sqrt(rank) - 8, 160.0);
    const double warmth = next();
    const double falloff = (1 - r2) * (1 - r2);
    const voxel::Colour tint = voxel::mix({0.72f, 0.84f, 1.25f}, {1.25f, 0.98f, 0.72f},
                                          static_cast<float>(warmth * warmth));
    return tint * static_cast<float>(brightness * falloff);
}

namespace {

float smooth(double low, double high, double v) noexcept {
    const double t = std::clamp((v - low) / (high - low), 0.0, 1.0);
    return static_cast<float>(t * t * (3 - 2 * t));
}

voxel::Colour night(double y) noexcept {
    const double low = 1 - y;
    return kNightLight * static_cast<float>(1 + 0.6 * low * low * low);
}

struct ClearSky {
    double turbidity;
    double altitude_rad;
    double height_m;
    bool operator==(const ClearSky&) const = default;
};

/// The last table is cached: a preview requests the same sky each time the camera moves, and it is
/// most of the work.
std::shared_ptr<const SkyTable> clear_sky(const ClearSky& asked, double scale) {
    static std::mutex mutex;
    static std::optional<ClearSky> last;
    static std::shared_ptr<const SkyTable> kept;
    {
        const std::lock_guard lock(mutex);
        if (last == asked)
            return kept;
    }
    const Atmosphere air(asked.turbidity);
    auto made = std::make_shared<const SkyTable>(Scattering(air, asked.altitude_rad),
                                                 asked.height_m, scale);
    const std::lock_guard lock(mutex);
    last = asked;
    kept = made;
    return made;
}

}  // namespace

Dome::Dome(const Sun& sun, const Settings& settings)
    : m_settings(settings),
      m_to_sun(sun.direction()),
      m_haze(settings.turbidity, settings.place_height_m, settings.visibility_km),
      m_clouds(settings.clouds) {
    const double flat = std::sqrt(m_to_sun.x * m_to_sun.x + m_to_sun.z * m_to_sun.z);
    m_sun_flat =
        flat > 1e-9 ? core::Vec3{m_to_sun.x / flat, 0, m_to_sun.z / flat} : core::Vec3{0, 0, 1};
    const Atmosphere air(settings.turbidity);
    const double scale = picture_scale();
    // The table takes radiance, the sun's light is what a white surface makes of its irradiance: a
    // factor of pi apart.
    m_table = clear_sky({settings.turbidity, sun.altitude_rad(), settings.place_height_m},
                        scale * det::kPi);
    if (sun.share_up() > 0) {
        // The horizon cuts the disc once, by its share: the air only dims what is left.
        const double sine = det::sin(sun.seen_altitude_rad());
        m_sun_light =
            in_gamut(sun_colour(air.transmittance(settings.place_height_m, sine), scale)) *
            static_cast<float>(sun.share_up());
    }
    constexpr double kRad = det::kPi / 180;
    m_stars = 1 - smooth(-10 * kRad, -5 * kRad, sun.altitude_rad());
    if (m_clouds.any())
        light_clouds(air, scale);
}

// Clouds are lit by the sun at their own height, where it sets later, by the clear sky above, and
// by the ground below.
void Dome::light_clouds(const Atmosphere& air, double scale) {
    m_cloud_sun = in_gamut(sun_colour(
        air.sunlight(m_settings.place_height_m + m_settings.cloud_height_m, m_to_sun.y), scale));
    constexpr int kRows = 8;
    constexpr int kColumns = 16;
    voxel::Colour mean;
    voxel::Colour flat;
    for (int i = 0; i < kRows; ++i)
        for (int j = 0; j < kColumns; ++j) {
            const double y = (i + 0.5) / kRows;
            const double r = std::sqrt(1 - y * y);
            const auto turn = det::sin_cos(2 * det::kPi * (j + 0.5) / kColumns);
            const voxel::Colour c =
                clear({r * turn.cos, y, r * turn.sin}) * (1.0f / (kRows * kColumns));
            mean = mean + c;
            flat = flat + c * static_cast<float>(2 * y);
        }
    m_cloud_above = mean;
    const voxel::Colour sun =
        m_sun_light * static_cast<float>(std::max(0.0, m_to_sun.y) * mean_passing());
    m_cloud_below = ground_colour() * (flat + sun);
}

double Dome::azimuth_cosine(core::Vec3 d, double flat) const noexcept {
    return flat > 1e-9 ? (d.x * m_sun_flat.x + d.z * m_sun_flat.z) / flat : 1;
}

voxel::Colour Dome::clear(core::Vec3 d) const noexcept {
    const double flat = std::sqrt(d.x * d.x + d.z * d.z);
    return in_gamut(m_table->at(d.y, azimuth_cosine(d, flat),
                                std::clamp(core::dot(d, m_to_sun), -1.0, 1.0))) +
           night(d.y);
}

voxel::Colour Dome::horizon(core::Vec3 d) const noexcept {
    // Not divided by the length of the flat part: towards the zenith and the nadir every azimuth
    // becomes the same. Below the horizon the glow around the sun ends in half the angle: hills and
    // woods shade the haze there.
    const double sun_cosine =
        core::dot(d.y < 0 ? core::normalized({d.x, 2 * d.y, d.z}) : d, m_to_sun);
    return in_gamut(m_table->at(0, std::clamp(azimuth_cosine(d, 1), -1.0, 1.0),
                                std::clamp(sun_cosine, -1.0, 1.0))) +
           night(0);
}

voxel::Colour Dome::radiance(core::Vec3 d) const noexcept {
    voxel::Colour c = clear(d);
    if (m_stars > 0)
        c = c + starlight(d) * kNightLight *
                    (m_stars * static_cast<float>(det::exp(-0.15 / (d.y + 0.03))));
    if (!m_clouds.any())
        return c;
    const CloudPlace at = cloud_place(d);
    const double depth = m_clouds.depth(at.x_m, at.z_m);
    if (depth <= 0)
        return c;
    // The air before the cloud is part of the clear sky; only what is behind it changes.
    const voxel::Colour cloud = cloud_light(at, depth, core::dot(d, m_to_sun));
    const voxel::Colour seen =
        m_haze.transmittance(d, at.distance_m) * static_cast<float>(1 - det::exp(-depth));
    return {c.r + seen.r * (cloud.r - c.r), c.g + seen.g * (cloud.g - c.g),
            c.b + seen.b * (cloud.b - c.b)};
}

Dome::CloudPlace Dome::cloud_place(core::Vec3 d) const noexcept {
    // The layer follows the Earth, so that it ends at a horizon.
    const double ry = Atmosphere::kEarth_m * d.y;
    const double h = m_settings.cloud_height_m;
    const double q = h * (2 * Atmosphere::kEarth_m + h);
    const double s = q / (ry + std::sqrt(ry * ry + q));
    return {s, m_settings.eye_m.x + d.x * s, m_settings.eye_m.z + d.z * s};
}

// Seen from below: thick parts are grey, since most light leaves them upwards; parts that face the
// sun past thinner neighbours are bright; thin ones before the sun glow. Diffuse transmission of a
// layer that absorbs nothing is about 1 / (1 + 0.13 depth). Ref: Bohren, "Multiple scattering of
// light and some of its observable consequences", Am. J. Phys. 1987 (two streams).
voxel::Colour Dome::cloud_light(const CloudPlace& at, double depth,
                                double sun_cosine) const noexcept {
    constexpr double kBack = 0.13;
    constexpr double kSide_m = 500;
    constexpr double kSideDepth = 0.09;
    const double aside =
        m_clouds.coarse_depth(at.x_m + m_sun_flat.x * kSide_m, at.z_m + m_sun_flat.z * kSide_m);
    const double through = 1 / (1 + kBack * depth);
    const double lit = det::exp(-kSideDepth * aside);
    const double c = std::max(0.0, sun_cosine);
    const double c2 = c * c;
    const double c8 = c2 * c2 * c2 * c2;
    const double glow = 0.9 * c8 * c8 * det::exp(-0.4 * depth) + 0.35 * c2 * c2;
    const double sun = (0.3 + 0.7 * std::max(0.0, m_to_sun.y)) *
                       (0.35 * through + 0.65 * lit * std::sqrt(through)) * (0.85 + glow);
    return m_cloud_sun * static_cast<float>(sun) + m_cloud_above * static_cast<float>(through) +
           m_cloud_below * static_cast<float>(1 - through);
}

double Dome::passing(core::Vec3 d) const noexcept {
    if (!m_clouds.any())
        return 1;
    const CloudPlace at = cloud_place(d);
    return det::exp(-m_clouds.depth(at.x_m, at.z_m));
}

double Dome::sun_passing(core::Vec3 p) const noexcept {
    const double up = m_settings.place_height_m + m_settings.cloud_height_m - p.y;
    if (!m_clouds.any() || !(up > 0))
        return 1;
    // A sun near the horizon shines through distant clouds; where the Earth's curvature would
    // matter, the sun is dim.
    constexpr double kLowest = 0.02;
    const double s = up / std::max(m_to_sun.y, kLowest);
    return det::exp(-m_clouds.depth(p.x + m_to_sun.x * s, p.z + m_to_sun.z * s));
}

voxel::Colour ground_colour() noexcept {
    static const voxel::Colour colour = [] {
        // Of the albedo under the sun's own light, as a share of what white would send.
        Spectrum white;
        white.fill(1);
        const voxel::Colour lit = sun_colour(Atmosphere::ground_albedo(), 1);
        const voxel::Colour all = sun_colour(white, 1);
        return voxel::Colour{lit.r / all.r, lit.g / all.g, lit.b / all.b};
    }();
    return colour;
}

}  // namespace terravox::sky
