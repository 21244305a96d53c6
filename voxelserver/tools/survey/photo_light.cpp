#include "voxelserver/tools/survey/orthophoto.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/util/det_math.hpp"
#include "voxelserver/tools/survey/randomness.hpp"

namespace terravox::survey {
namespace {

constexpr double kDegree = det::kPi / 180;

double to_linear_value(double srgb) {
    const double s = srgb / 255;
    return s <= 0.04045 ? s / 12.92 : det::pow((s + 0.055) / 1.055, 2.4);
}

double to_srgb_value(double linear) {
    const double v = std::clamp(linear, 0.0, 1.0);
    return 255 * (v <= 0.0031308 ? 12.92 * v : 1.055 * det::pow(v, 1 / 2.4) - 0.055);
}

using Channels = std::array<double, 3>;

/// The light of one flight, relative to that of a flat, sunlit surface.
class Flight {
public:
    Flight(const SquareModel& model, const PhotoLight& light, const Painting& painting,
           int margin_px)
        : m_seed(model.seed()),
          m_light(light),
          m_painting(painting),
          m_margin_px(margin_px),
          m_east(det::sin(light.azimuth_deg * kDegree)),
          m_north(det::cos(light.azimuth_deg * kDegree)),
          m_rise(det::tan(light.altitude_deg * kDegree)) {
        // The lower the sun and the thicker the haze, the more light comes from the sky, which is
        // bluer than the sun.
        const double sky = std::min(0.12 + 0.05 / m_rise + 0.35 * light.haze, 0.7);
        const double blue = 1 - 0.6 * light.haze;
        m_sky = {sky * (1 - 0.25 * blue), sky, sky * (1 + 0.4 * blue)};
        for (std::size_t i = 0; i < m_linear.size(); ++i)
            m_linear[i] = to_linear_value(static_cast<double>(i));
    }

    [[nodiscard]] Channels photo(int column, int row, Vec2 p) const {
        const std::size_t i = index(column, row);
        const Painting::Slope slope = m_painting.slope[i];
        const double up = 1 / std::sqrt(1 + slope.east * slope.east + slope.north * slope.north);
        // The cosine at the surface over that of flat ground.
        const double facing = up * (1 - (m_east * slope.east + m_north * slope.north) / m_rise);
        const double sun = std::max(facing, 0.0) * sunlit(column, row) * through_clouds(p);
        Channels out{};
        for (std::size_t c = 0; c < 3; ++c) {
            const double light = (1 - m_sky[c]) * sun + m_sky[c] * (1 + up) / 2;
            const double seen =
                (1 - 0.35 * m_light.haze) * light * m_linear[m_painting.rgb[3 * i + c]];
            const double veil = m_light.haze * (0.04 + 0.01 * static_cast<double>(c));
            out[c] = seen + veil;
        }
        return out;
    }

private:
    [[nodiscard]] std::size_t index(int column, int row) const noexcept {
        return static_cast<std::size_t>(row + m_margin_px) *
                   static_cast<std::size_t>(m_painting.side_px) +
               static_cast<std::size_t>(column + m_margin_px);
    }

    /// The share of the sun's disc that is seen from a pixel, [0, 1].
    [[nodiscard]] double sunlit(int column, int row) const {
        constexpr double kTallest_m = 60;
        const double own = m_painting.top_m[index(column, row)];
        // Half a degree wide, as a range of slopes.
        const double soft = 0.0046 * (1 + m_rise * m_rise);
        const int last =
            static_cast<int>(std::min(kShadowReach_m, kTallest_m / m_rise) / kOrthophotoPixel_m);
        double lit = 1;
        for (int step = 1; step <= last && lit > 0; ++step) {
            const double run_m = step * kOrthophotoPixel_m;
            const auto i = index(column + static_cast<int>(std::floor(step * m_east + 0.5)),
                                 row - static_cast<int>(std::floor(step * m_north + 0.5)));
            const double slope = (m_painting.top_m[i] - own) / run_m;
            lit = std::min(lit, 0.5 + (m_rise - slope) / (2 * soft));
        }
        return std::max(lit, 0.0);
    }

    /// The share of the sun's light that clouds let pass.
    [[nodiscard]] double through_clouds(Vec2 p) const {
        constexpr double kCloud_m = 180;
        const double thick =
            smoothstep(-0.1, 0.35, fractal_2d(m_seed + 91, p.x / kCloud_m, p.y / kCloud_m, 3));
        return 1 - m_light.clouds * thick;
    }

    std::uint64_t m_seed;
    PhotoLight m_light;
    const Painting& m_painting;
    int m_margin_px;
    double m_east;   ///< towards the sun, in plan
    double m_north;  ///< the same
    double m_rise;   ///< of its rays, over the run in plan
    Channels m_sky{};
    std::array<double, 256> m_linear{};
};

}  // namespace

LitPhoto take_photo(const SquareModel& model, const PhotoLight& light) {
    const Painting painting = paint(model, Shading::kNone, kShadowReach_m);
    const int margin = static_cast<int>(kShadowReach_m / kOrthophotoPixel_m);
    const int side = painting.side_px - 2 * margin;
    const Flight flight(model, light, painting, margin);
    const Box2 box = model.extent().box();
    LitPhoto out{{side, 3, {}}, {side, 3, {}}};
    for (int row = 0; row < side; ++row)
        for (int column = 0; column < side; ++column) {
            const Vec2 p{box.x0 + (column + 0.5) * kOrthophotoPixel_m,
                         box.y1 - (row + 0.5) * kOrthophotoPixel_m};
            const Channels seen = flight.photo(column, row, p);
            const auto at = 3 * (static_cast<std::size_t>(row + margin) *
                                     static_cast<std::size_t>(painting.side_px) +
                                 static_cast<std::size_t>(column + margin));
            // The camera's noise.
            const auto east = static_cast<std::int64_t>(std::floor(p.x / kOrthophotoPixel_m));
            const auto north = static_cast<std::int64_t>(std::floor(p.y / kOrthophotoPixel_m));
            Random random(compute_hash(model.seed() + 92, east, north));
            for (std::size_t c = 0; c < 3; ++c) {
                const double value = to_srgb_value(seen[c]) + 1.2 * random.normal();
                out.photo.pixels.push_back(
                    static_cast<std::uint8_t>(std::clamp(value + 0.5, 0.0, 255.0)));
                out.albedo.pixels.push_back(painting.rgb[at + c]);
            }
        }
    return out;
}

}  // namespace terravox::survey
