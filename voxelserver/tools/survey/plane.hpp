#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

/// Plane geometry in the place frame: metres east (x) and north (y) of the place's centre. The
/// whole generator uses only + - * / sqrt and floor, which IEEE 754 rounds the same on every
/// machine; a survey does not depend on the C library.
namespace terravox::survey {

struct Vec2 {
    double x = 0;
    double y = 0;
    constexpr Vec2 operator+(Vec2 o) const noexcept { return {x + o.x, y + o.y}; }
    constexpr Vec2 operator-(Vec2 o) const noexcept { return {x - o.x, y - o.y}; }
    constexpr Vec2 operator*(double f) const noexcept { return {x * f, y * f}; }
};

[[nodiscard]] constexpr double dot(Vec2 a, Vec2 b) noexcept {
    return a.x * b.x + a.y * b.y;
}
[[nodiscard]] inline double length(Vec2 v) noexcept {
    return std::sqrt(v.x * v.x + v.y * v.y);
}
/// @return v scaled to length 1, or east for a zero vector
[[nodiscard]] inline Vec2 unit(Vec2 v) noexcept {
    const double l = length(v);
    return l > 0 ? v * (1.0 / l) : Vec2{1, 0};
}
/// A quarter turn to the left.
[[nodiscard]] constexpr Vec2 turn_left(Vec2 v) noexcept {
    return {-v.y, v.x};
}

/// [x0, x1) by [y0, y1), metres.
struct Box2 {
    double x0 = 0;
    double y0 = 0;
    double x1 = 0;
    double y1 = 0;
    [[nodiscard]] constexpr Box2 expanded(double m) const noexcept {
        return {x0 - m, y0 - m, x1 + m, y1 + m};
    }
    [[nodiscard]] constexpr bool contains(Vec2 p) const noexcept {
        return p.x >= x0 && p.x < x1 && p.y >= y0 && p.y < y1;
    }
    [[nodiscard]] constexpr bool overlaps(const Box2& o) const noexcept {
        return x0 < o.x1 && o.x0 < x1 && y0 < o.y1 && o.y0 < y1;
    }
};

/// The centre of the place in EPSG:3794, metres; the middle of the square TM_462_101.
inline constexpr double kPlaceEasting_m = 462500;
inline constexpr double kPlaceNorthing_m = 101500;

[[nodiscard]] constexpr double lerp(double a, double b, double t) noexcept {
    return a + (b - a) * t;
}
/// 0 below low, 1 above high, a smooth cubic between.
[[nodiscard]] constexpr double smoothstep(double low, double high, double v) noexcept {
    const double t = std::clamp((v - low) / (high - low), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}
/// A smooth hill: 1 in the middle, 0 from a distance of 1 outwards.
[[nodiscard]] constexpr double bump(double distance) noexcept {
    const double t = 1.0 - distance * distance;
    return t > 0 ? t * t : 0.0;
}

/// The nearest point on a line segment.
struct OnSegment {
    double distance_m = 0;
    double along = 0;  ///< [0, 1] from a to b
};
[[nodiscard]] inline OnSegment nearest_on_segment(Vec2 p, Vec2 a, Vec2 b) noexcept {
    const Vec2 ab = b - a;
    const double squared = dot(ab, ab);
    const double along = squared > 0 ? std::clamp(dot(p - a, ab) / squared, 0.0, 1.0) : 0.0;
    return {length(p - (a + ab * along)), along};
}

}  // namespace terravox::survey
