#include "raytracer/core/sky/sky.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/det_math.hpp"
#include "raytracer/core/sky/dome.hpp"

namespace terravox::sky {
namespace {

constexpr int kNodes = 25;  // along an edge; odd, so that all six axes are nodes

core::Vec3 normal_at(int i, int j) noexcept {
    const double u = 2.0 * i / (kNodes - 1) - 1;
    const double v = 2.0 * j / (kNodes - 1) - 1;
    const double y = 1 - std::fabs(u) - std::fabs(v);
    if (y >= 0)
        return core::normalized({u, y, v});
    return core::normalized(
        {(1 - std::fabs(v)) * (u >= 0 ? 1 : -1), y, (1 - std::fabs(u)) * (v >= 0 ? 1 : -1)});
}

}  // namespace

AmbientTable::AmbientTable(std::span<const LightFrom> light) {
    m_nodes.reserve(kNodes * kNodes);
    for (int j = 0; j < kNodes; ++j)
        for (int i = 0; i < kNodes; ++i) {
            const core::Vec3 n = normal_at(i, j);
            double r = 0;
            double g = 0;
            double b = 0;
            for (const LightFrom& from : light) {
                const double w = std::max(0.0, core::dot(n, from.direction)) * from.solid_angle;
                r += w * static_cast<double>(from.radiance.r);
                g += w * static_cast<double>(from.radiance.g);
                b += w * static_cast<double>(from.radiance.b);
            }
            m_nodes.push_back({static_cast<float>(r / det::kPi), static_cast<float>(g / det::kPi),
                               static_cast<float>(b / det::kPi)});
        }
}

voxel::Colour AmbientTable::at(core::Vec3 n) const noexcept {
    const double sum = std::fabs(n.x) + std::fabs(n.y) + std::fabs(n.z);
    if (m_nodes.empty() || !(sum > 0 && sum < 1e300))
        return {};
    double u = n.x / sum;
    double v = n.z / sum;
    if (n.y < 0) {
        const double folded = (1 - std::fabs(v)) * (u >= 0 ? 1 : -1);
        v = (1 - std::fabs(u)) * (v >= 0 ? 1 : -1);
        u = folded;
    }
    u = (u + 1) / 2 * (kNodes - 1);
    v = (v + 1) / 2 * (kNodes - 1);
    const int i = std::clamp(static_cast<int>(u), 0, kNodes - 2);
    const int j = std::clamp(static_cast<int>(v), 0, kNodes - 2);
    const voxel::Colour* node = &m_nodes[static_cast<std::size_t>(j * kNodes + i)];
    const auto a = static_cast<float>(u - i);
    const auto b = static_cast<float>(v - j);
    return voxel::mix(voxel::mix(node[0], node[1], a),
                      voxel::mix(node[kNodes], node[kNodes + 1], a), b);
}

namespace {

constexpr double kCell_sr = 2 * det::kPi / (SkySampler::kColumns * SkySampler::kRows);
// Share that every direction gets: a cell's mean may be dark where a corner of it is not.
constexpr double kEven = 0.05;
constexpr double kBelowOne = 0x1.fffffffffffffp-1;

}  // namespace

template <int kCount>
void SkySampler::Choice<kCount>::make_guide() noexcept {
    std::size_t first = 0;
    for (std::size_t i = 0; i < kCount; ++i) {
        while (first + 1 < kCount && ends[first] <= static_cast<double>(i) / kCount)
            ++first;
        guide[i] = static_cast<std::uint8_t>(first);
    }
}

template <int kCount>
int SkySampler::Choice<kCount>::find(double& u) const noexcept {
    // The product of a power of two is exact, so the guide is never beyond the result.
    static_assert((kCount & (kCount - 1)) == 0);
    std::size_t i = guide[static_cast<std::size_t>(std::clamp(u, 0.0, kBelowOne) * kCount)];
    while (i + 1 < kCount && ends[i] <= u)
        ++i;
    const double low = i > 0 ? ends[i - 1] : 0;
    const double size = ends[i] - low;
    u = size > 0 ? std::clamp((u - low) / size, 0.0, 1.0) : 0.5;
    return static_cast<int>(i);
}

SkySampler::SkySampler(const std::vector<double>& luminance)
    : m_columns(kRows), m_pdf(kRows * kColumns) {
    double all = 0;
    for (const double l : luminance)
        all += l;
    const double cells = kRows * kColumns;
    double rows = 0;
    for (std::size_t row = 0; row < kRows; ++row) {
        auto& ends = m_columns[row].ends;
        double sum = 0;
        for (std::size_t column = 0; column < kColumns; ++column) {
            const std::size_t cell = row * kColumns + column;
            const double share =
                all > 0 ? (1 - kEven) * luminance[cell] / all + kEven / cells : 1 / cells;
            m_pdf[cell] = share / kCell_sr;
            ends[column] = sum += share;
        }
        for (double& end : ends)
            end /= sum;
        m_columns[row].make_guide();
        m_rows.ends[row] = rows += sum;
    }
    for (double& end : m_rows.ends)
        end /= rows;
    m_rows.make_guide();
}

SkySample SkySampler::sample(double u, double v) const noexcept {
    const int row = m_rows.find(v);
    const int column = m_columns[static_cast<std::size_t>(row)].find(u);
    const double y = (row + v) / kRows;
    const double flat = std::sqrt(std::max(0.0, 1 - y * y));
    const auto turn = det::sin_cos(2 * det::kPi * (column + u) / kColumns);
    return {{flat * turn.cos, y, flat * turn.sin},
            m_pdf[static_cast<std::size_t>(row * kColumns + column)]};
}

double SkySampler::pdf(core::Vec3 d) const noexcept {
    if (!(d.y >= 0))
        return 0;
    const int row = std::min(static_cast<int>(std::min(d.y, 1.0) * kRows), kRows - 1);
    const double turn = det::atan2(d.z, d.x) / (2 * det::kPi);
    const int column =
        std::clamp(static_cast<int>((turn < 0 ? turn + 1 : turn) * kColumns), 0, kColumns - 1);
    return m_pdf[static_cast<std::size_t>(row * kColumns + column)];
}

namespace {

// How high above the plain without end the eye seems to be: high enough to have haze below it, a
// quiet ground for a model.
constexpr double kBackdrop_m = 2500;
// Directions along each edge of a sampler's cell that its light is summed over.
constexpr int kFine = 2;
constexpr int kLowRows = 32, kLowColumns = 64;  // of the lower half, whose light is smooth

voxel::Colour to_colour(const std::array<double, 3>& c) noexcept {
    const auto channel = [](double v) { return static_cast<float>(std::max(0.0, v)); };
    return {channel(c[0]), channel(c[1]), channel(c[2])};
}

Dome::Settings dome_settings(const scene::Scene::Sky& sky, double place_height_m,
                             core::Vec3 eye_m) {
    Dome::Settings s;
    s.turbidity = std::clamp(sky.turbidity, 1.0, 20.0);
    // Worlds may lie below the sea, or in a game's heights; air is thinner only above it.
    s.place_height_m = std::clamp(place_height_m, 0.0, 10'000.0);
    s.clouds = sky.clouds;
    s.cloud_height_m = std::clamp(sky.cloud_height_m, 100.0, 12'000.0);
    s.eye_m = eye_m;
    if (sky.visibility_km && *sky.visibility_km > 0)
        s.visibility_km = sky.visibility_km;
    return s;
}

core::Vec3 direction_at(double y, double turn) noexcept {
    const double flat = std::sqrt(std::max(0.0, 1 - y * y));
    const auto both = det::sin_cos(2 * det::kPi * turn);
    return {flat * both.cos, y, flat * both.sin};
}

}  // namespace

/// All of it, built once.
class Sky::Parts {
public:
    Parts(const geo::SunPosition& at, const scene::Scene::Sun& sun_settings,
          const scene::Scene::Sky& sky, double place_height_m, core::Vec3 eye_m)
        : sun(at, sun_settings.size),
          dome(sun, dome_settings(sky, place_height_m, eye_m)),
          strength(static_cast<float>(std::max(0.0, sky.strength))) {
        if (sky.model == core::SkyModel::kUniform)
            uniform = to_colour(sky.colour.value_or(std::array<double, 3>{1, 1, 1})) * strength;
        has_air = sky.visibility_km ? *sky.visibility_km > 0 : !uniform;
        const voxel::Colour natural =
            sun_settings.light ? to_colour(*sun_settings.light) * static_cast<float>(sun.share_up())
                               : dome.sun_light();
        sun_light = natural * static_cast<float>(std::max(0.0, sun_settings.strength));
        gather();
    }

    voxel::Colour radiance(core::Vec3 d) const noexcept {
        if (uniform)
            return *uniform;
        if (d.y >= 0)
            return dome.radiance(d) * strength;
        const voxel::Colour left = dome.haze().transmittance(d, kBackdrop_m / -d.y);
        return ground * left + horizon(d) * voxel::Colour{1 - left.r, 1 - left.g, 1 - left.b};
    }
    voxel::Colour horizon(core::Vec3 d) const noexcept {
        return uniform ? *uniform : dome.horizon(d) * strength;
    }

    const Sun sun;
    const Dome dome;
    const float strength;
    std::optional<voxel::Colour> uniform;
    bool has_air = true;
    voxel::Colour sun_light;
    voxel::Colour ground;
    AmbientTable ambient;
    std::array<voxel::Colour, 6> face_ambient;
    std::optional<SkySampler> sampler;

private:
    // Step 1: the light of each cell of the upper half, which is all that the ground gets in
    // addition to the sun. Step 2: the lower half, which is that ground behind haze. Step 3: both
    // on every normal.
    void gather() {
        std::vector<LightFrom> light;
        std::vector<double> bright;
        constexpr double kCell_sr = 2 * det::kPi / (SkySampler::kRows * SkySampler::kColumns);
        voxel::Colour on_ground;
        for (int row = 0; row < SkySampler::kRows; ++row)
            for (int column = 0; column < SkySampler::kColumns; ++column) {
                voxel::Colour mean;
                for (int i = 0; i < kFine * kFine; ++i) {
                    const double y = (row + (i / kFine + 0.5) / kFine) / SkySampler::kRows;
                    const double turn = (column + (i % kFine + 0.5) / kFine) / SkySampler::kColumns;
                    mean = mean + radiance(direction_at(y, turn)) * (1.0f / (kFine * kFine));
                }
                const core::Vec3 d = direction_at((row + 0.5) / SkySampler::kRows,
                                                  (column + 0.5) / SkySampler::kColumns);
                on_ground = on_ground + mean * static_cast<float>(d.y * kCell_sr / det::kPi);
                light.push_back({d, mean, kCell_sr});
                bright.push_back(static_cast<double>(voxel::luminance(mean)));
            }
        sampler.emplace(bright);
        ground = ground_colour() *
                 (on_ground + sun_light * static_cast<float>(std::max(0.0, sun.direction().y) *
                                                             dome.mean_passing()));
        for (int row = 0; row < kLowRows; ++row)
            for (int column = 0; column < kLowColumns; ++column) {
                const core::Vec3 d =
                    direction_at(-(row + 0.5) / kLowRows, (column + 0.5) / kLowColumns);
                light.push_back({d, radiance(d), 2 * det::kPi / (kLowRows * kLowColumns)});
            }
        ambient = AmbientTable(light);
        for (std::size_t face = 0; face < face_ambient.size(); ++face) {
            const core::Vec3 normal = core::to_normal(static_cast<core::Face>(face));
            face_ambient[face] = uniform ? *uniform : ambient.at(normal);
        }
    }
};

Sky::Sky(const geo::SunPosition& sun, const scene::Scene::Sun& sun_settings,
         const scene::Scene::Sky& sky_settings, double place_height_m, core::Vec3 eye_m)
    : m_parts(std::make_shared<Parts>(sun, sun_settings, sky_settings, place_height_m, eye_m)) {}

core::Vec3 Sky::to_sun() const noexcept {
    return m_parts->sun.direction();
}
bool Sky::sun_up() const noexcept {
    return m_parts->sun.share_up() > 0;
}
voxel::Colour Sky::sun_light() const noexcept {
    return m_parts->sun_light;
}
double Sky::sun_radius_rad() const noexcept {
    return m_parts->sun.radius_rad();
}
core::Vec3 Sky::sample_sun(double u, double v) const noexcept {
    return m_parts->sun.sample(u, v);
}

voxel::Colour Sky::sun_disc(core::Vec3 d) const noexcept {
    const double share = m_parts->sun.disc(d);
    return share > 0
               ? m_parts->sun_light *
                     static_cast<float>(share * (m_parts->uniform ? 1 : m_parts->dome.passing(d)))
               : voxel::Colour{};
}

voxel::Colour Sky::radiance(core::Vec3 d) const noexcept {
    return m_parts->radiance(d);
}
voxel::Colour Sky::ambient(core::Vec3 normal) const noexcept {
    return m_parts->uniform ? *m_parts->uniform : m_parts->ambient.at(normal);
}
voxel::Colour Sky::ambient(core::Face face) const noexcept {
    return m_parts->face_ambient[static_cast<std::size_t>(face)];
}
bool Sky::uneven() const noexcept {
    return !m_parts->uniform && m_parts->strength > 0;
}
SkySample Sky::sample(double u, double v) const noexcept {
    return m_parts->sampler->sample(u, v);
}
double Sky::pdf(core::Vec3 d) const noexcept {
    return m_parts->sampler->pdf(d);
}

Air Sky::air(core::Vec3 d, double metres) const noexcept {
    if (!m_parts->has_air)
        return {};
    const voxel::Colour left = m_parts->dome.haze().transmittance(d, metres);
    return {left, m_parts->horizon(d) * voxel::Colour{1 - left.r, 1 - left.g, 1 - left.b}};
}

float Sky::cloud_shadow(core::Vec3 point_m) const noexcept {
    return m_parts->uniform ? 1 : static_cast<float>(m_parts->dome.sun_passing(point_m));
}

}  // namespace terravox::sky
