#pragma once

#include <cmath>

namespace terravox::core {

/// A vector in voxel units of level 0; x east, y up, z south.
struct Vec3 {
    double x = 0;
    double y = 0;
    double z = 0;
    [[nodiscard]] double operator[](int axis) const noexcept {
        return axis == 0 ? x : axis == 1 ? y : z;
    }
    friend Vec3 operator+(Vec3 a, Vec3 b) noexcept { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
    friend Vec3 operator-(Vec3 a, Vec3 b) noexcept { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
    friend Vec3 operator*(Vec3 a, double s) noexcept { return {a.x * s, a.y * s, a.z * s}; }
    friend Vec3 operator-(Vec3 a) noexcept { return {-a.x, -a.y, -a.z}; }
    friend bool operator==(const Vec3&, const Vec3&) = default;
};
[[nodiscard]] inline double dot(Vec3 a, Vec3 b) noexcept {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
[[nodiscard]] inline Vec3 cross(Vec3 a, Vec3 b) noexcept {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
[[nodiscard]] inline double length(Vec3 a) noexcept {
    return std::sqrt(dot(a, a));
}
[[nodiscard]] inline Vec3 normalized(Vec3 a) noexcept {
    return a * (1 / length(a));
}

struct Ray {
    Vec3 origin;
    Vec3 direction;  ///< need not be of unit length; t is in multiples of it
};

/// Faces of a voxel, named by their outward normal.
enum class Face : signed char {
    kNone = -1,
    kWest = 0,
    kEast = 1,
    kBottom = 2,
    kTop = 3,
    kNorth = 4,
    kSouth = 5
};

[[nodiscard]] constexpr Face to_face(int axis, bool towards_positive) noexcept {
    return static_cast<Face>(axis * 2 + (towards_positive ? 1 : 0));
}
[[nodiscard]] constexpr int to_axis(Face face) noexcept {
    return static_cast<int>(face) >> 1;
}
[[nodiscard]] constexpr int to_sign(Face face) noexcept {
    return (static_cast<int>(face) & 1) != 0 ? 1 : -1;
}
[[nodiscard]] inline Vec3 to_normal(Face face) noexcept {
    const double s = to_sign(face);
    return to_axis(face) == 0 ? Vec3{s, 0, 0} : to_axis(face) == 1 ? Vec3{0, s, 0} : Vec3{0, 0, s};
}

}  // namespace terravox::core
