#include "raytracer/core/animate/animation.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <type_traits>
#include <utility>

#include "common/geo/lat_lon.hpp"
#include "common/util/error.hpp"
#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/scene/scene_fields.hpp"
#include "raytracer/core/scene/views.hpp"

namespace terravox::animate {
namespace {

// Of the parabola through three neighbours: Catmull and Rom's choice where times are even.
// Ref: Catmull & Rom, "A Class of Local Interpolating Splines", 1974.
double round_rate(double h0, double h1, double slope0, double slope1) noexcept {
    return (slope0 * h1 + slope1 * h0) / (h0 + h1);
}

// A weighted harmonic mean, or a stop at a summit.
// Ref: Fritsch & Butland, "A Method for Constructing Local Monotone Piecewise Cubic Interpolants",
// 1984.
double monotone_rate(double h0, double h1, double slope0, double slope1) noexcept {
    if (!(slope0 * slope1 > 0))
        return 0;
    const double w0 = 2 * h1 + h0;
    const double w1 = h1 + 2 * h0;
    return (w0 + w1) / (w0 / slope0 + w1 / slope1);
}

}  // namespace

SmoothPath::SmoothPath(std::vector<double> times, std::vector<double> values, Kind kind,
                       bool at_rest)
    : m_times(std::move(times)), m_values(std::move(values)), m_rates(m_times.size(), 0.0) {
    const std::size_t n = m_times.size();
    const auto width = [&](std::size_t i) { return m_times[i + 1] - m_times[i]; };
    const auto slope = [&](std::size_t i) { return (m_values[i + 1] - m_values[i]) / width(i); };
    for (std::size_t i = 1; i + 1 < n; ++i)
        m_rates[i] = (kind == Kind::kRound ? round_rate : monotone_rate)(width(i - 1), width(i),
                                                                         slope(i - 1), slope(i));
    if (n > 1 && !at_rest) {
        m_rates.front() = slope(0);
        m_rates.back() = slope(n - 2);
    }
}

double SmoothPath::at(double time) const noexcept {
    if (!(time > m_times.front()))
        return m_values.front();
    if (time >= m_times.back())
        return m_values.back();
    const auto next = static_cast<std::size_t>(
        std::upper_bound(m_times.begin(), m_times.end(), time) - m_times.begin());
    const std::size_t i = next - 1;
    const double h = m_times[next] - m_times[i];
    const double s = (time - m_times[i]) / h;
    const double r = 1 - s;
    if (m_values[i] == m_values[next] && m_rates[i] == 0 && m_rates[next] == 0)
        return m_values[i];
    return m_values[i] * (r * r * (1 + 2 * s)) + m_values[next] * (s * s * (3 - 2 * s)) +
           h * (m_rates[i] * (s * r * r) - m_rates[next] * (s * s * r));
}

namespace {

using Triple = std::array<double, 3>;

/// East and north of a centre, turned clockwise as seen from above.
struct Turn {
    explicit Turn(double deg)
        : cos(scene::trig::cos(deg * scene::trig::kRadPerDeg)),
          sin(scene::trig::sin(deg * scene::trig::kRadPerDeg)) {}
    void apply(double& east, double& north) const noexcept {
        const double e = east * cos + north * sin;
        north = north * cos - east * sin;
        east = e;
    }
    double cos;
    double sin;
};

Triple turned(const Triple& point, const Triple& centre, core::CoordinateSpace space,
              const Turn& turn) {
    if (space == core::CoordinateSpace::kLatLon) {
        const geo::LocalFrame frame({centre[0], centre[1]}, 0);
        geo::EastNorthUp local = frame.to_local({point[0], point[1]}, 0);
        turn.apply(local.east_m, local.north_m);
        double height_m = 0;
        const geo::LatLon place = frame.to_lat_lon(local, height_m);
        return {place.lat_deg, place.lon_deg, point[2]};
    }
    // In voxels z grows to the south, the northing to the north.
    const std::size_t across = space == core::CoordinateSpace::kVoxel ? 2 : 1;
    const double sign = space == core::CoordinateSpace::kVoxel ? -1 : 1;
    double east = point[0] - centre[0];
    double north = sign * (point[across] - centre[across]);
    turn.apply(east, north);
    Triple out = point;
    out[0] = centre[0] + east;
    out[across] = centre[across] + sign * north;
    return out;
}

}  // namespace

void Animation::apply_base(scene::Scene& scene) const {
    scene::read_scene_table(m_base, m_attempt, scene);
}

void Animation::turn(scene::Scene& scene, double time_s) const {
    scene::Scene::Camera& c = scene.camera;
    const auto centre = m_turntable->target ? m_turntable->target : c.target;
    if (m_turntable->target && !c.position && !core::is_parallel(c.projection))
        throw util::UsageError(
            m_attempt + ": turntable.target needs camera.position, from where it is circled");
    const double deg = std::remainder(
        360 * m_turntable->turns * std::min(time_s / m_turntable->seconds, 1.0), 360);
    if (m_turntable->target && !c.target)
        c.target = m_turntable->target;
    if (deg == 0)
        return;
    c.azimuth_deg = std::remainder(c.azimuth_deg + deg, 360);
    if (!c.position)
        return;
    const Turn turn(deg);
    c.position = turned(*c.position, *centre, c.space, turn);
    if (m_turntable->target)
        c.target = turned(*c.target, *centre, c.space, turn);
}

// Words and whole numbers keep their value from one key to the next.
const Animation::Word& Animation::word_at(const Track& track, double time_s) {
    const auto next =
        std::upper_bound(track.times.begin(), track.times.end(), time_s) - track.times.begin();
    return track.words[static_cast<std::size_t>(std::max<std::ptrdiff_t>(next - 1, 0))];
}

scene::Scene Animation::at(int frame, const scene::Scene& base) const {
    scene::Scene out = base;
    const double time = frame / m_fps;
    scene::visit_fields(out, [&](std::string_view path, auto& field, const scene::FieldRule&) {
        const auto found = m_tracks.find(path);
        if (found == m_tracks.end())
            return;
        const Track& track = found->second;
        using Field = std::decay_t<decltype(field)>;
        if constexpr (std::is_same_v<Field, double> || std::is_same_v<Field, std::optional<double>>)
            field = track.paths[0].at(time);
        else if constexpr (std::is_same_v<Field, std::optional<Triple>>)
            field =
                Triple{track.paths[0].at(time), track.paths[1].at(time), track.paths[2].at(time)};
        else if constexpr (std::is_same_v<Field, int> || std::is_same_v<Field, bool> ||
                           std::is_same_v<Field, std::string>)
            field = std::get<Field>(word_at(track, time));
        else if constexpr (core::WordEnum<Field>)
            field = core::from_word<Field>(std::get<std::string>(word_at(track, time))).value();
    });
    if (m_day) {
        if (out.sun.altitude_deg || out.sun.azimuth_deg)
            throw util::UsageError(
                m_attempt +
                ": [day] and sun.altitude_deg, sun.azimuth_deg say both where the sun "
                "stands; give one of them");
        const double share = std::min(time / m_day->seconds, 1.0);
        out.sun.time_h =
            std::clamp(m_day->from + (m_day->to - m_day->from) * share,
                       std::min(m_day->from, m_day->to), std::max(m_day->from, m_day->to));
    }
    if (m_turntable) {
        if (out.camera.position && !out.camera.target && !m_turntable->target)
            throw util::UsageError(
                m_attempt + ": [turntable] needs camera.target or its own target to go around");
        turn(out, time);
    }
    return out;
}

}  // namespace terravox::animate
