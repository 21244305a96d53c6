#pragma once

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "tests/common/content.hpp"
#include "voxelserver/data/pointcloud/point.hpp"

namespace terravox::test {

enum class PlyKind { kText, kLittle, kBig };

template <class T>
void add_number(std::string& to, T value, PlyKind kind) {
    if (kind == PlyKind::kText) {
        char text[40];
        std::snprintf(text, sizeof text, "%.17g ", static_cast<double>(value));
        to += text;
        return;
    }
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof value);
    if (kind == PlyKind::kBig)
        std::reverse(bytes.begin(), bytes.end());
    to += bytes;
}

/// A PLY file of points: doubles, 16-bit colours, classes and returns.
/// @param comment a line of the header after "comment ", empty = none
inline std::string ply_bytes(const std::vector<pointcloud::Point>& points, PlyKind kind,
                             const std::string& comment = "") {
    const char* const name = kind == PlyKind::kText     ? "ascii"
                             : kind == PlyKind::kLittle ? "binary_little_endian"
                                                        : "binary_big_endian";
    std::string out = "ply\nformat " + std::string(name) + " 1.0\n";
    if (!comment.empty())
        out += "comment " + comment + "\n";
    out += "element vertex " + std::to_string(points.size()) +
           "\nproperty double x\nproperty double y\nproperty double z\nproperty ushort red\n"
           "property ushort green\nproperty ushort blue\nproperty float intensity\n"
           "property uchar classification\nproperty uchar return_number\n"
           "property uchar number_of_returns\nend_header\n";
    for (const pointcloud::Point& p : points) {
        add_number(out, p.x, kind);
        add_number(out, p.y, kind);
        add_number(out, p.z, kind);
        for (const std::uint16_t channel : p.rgb)
            add_number(out, channel, kind);
        add_number(out, 0.5F, kind);
        add_number(out, p.classification, kind);
        add_number(out, p.return_number, kind);
        add_number(out, p.return_count, kind);
        if (kind == PlyKind::kText)
            out += "\n";
    }
    return out;
}

}  // namespace terravox::test
