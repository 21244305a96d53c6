#include "voxelserver/serve/gkot/gkot_origin.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <vector>

#include "voxelserver/serve/gkot/gkot_box.hpp"

namespace terravox::gkot {
namespace {

/// Lowest and highest top of a box column, in voxels.
struct Tops {
    std::int32_t low = 0;
    std::int32_t high = 0;
};

// As a reply would contain them, so that "the top" means the same in both.
std::optional<Tops> tops_around(const voxel::VoxelBounds& bounds, std::int64_t x, std::int64_t z,
                                const FetchBox& fetch) {
    std::optional<Tops> out;
    for (const std::int64_t top : column_tops(bounds, x, z, fetch)) {
        if (top == kNoTop)
            continue;
        const auto y = static_cast<std::int32_t>(top);
        if (!out)
            out = {y, y};
        out->low = std::min(out->low, y);
        out->high = std::max(out->high, y);
    }
    return out;
}

void append_number(std::string& out, const char* name, double value) {
    // The longest number has 309 digits before the decimal point; the shortest round-trip form has
    // few after it.
    char text[512];
    const auto end = std::to_chars(text, text + sizeof text, value + 0.0, std::chars_format::fixed)
                         .ptr;  // + 0.0: avoids "-0"
    out += (out.size() > 1 ? ",\"" : "\"") + std::string(name) + "\":" + std::string(text, end);
}

}  // namespace

std::int64_t voxel_of(double value, double unit) noexcept {
    // 2^53: beyond any world, and integers are still exact.
    constexpr double kMax = 9007199254740992.0;
    return static_cast<std::int64_t>(std::clamp(std::floor(value / unit), -kMax, kMax));
}

double height_of(std::int64_t y, double voxel_m) noexcept {
    double height = static_cast<double>(y) * voxel_m;
    while (voxel_of(height, voxel_m) < y)
        height = std::nextafter(height, std::numeric_limits<double>::infinity());
    return height;
}

Origin find_origin(const voxel::WorldInfo& info, const OriginRequest& request,
                   const FetchBox& fetch) {
    Origin out;
    out.tmx = request.tmx;
    out.tmy = request.tmy;
    if (info.bounds.empty())
        return out;
    const double unit = info.crs_units_per_voxel;
    const auto tops =
        tops_around(info.bounds, voxel_of(request.tmx, unit), voxel_of(-request.tmy, unit), fetch);
    out.tmz = out.zmin = height_of(tops ? tops->low : info.bounds.min[1], info.voxel_m);
    out.zmax = height_of(tops ? tops->high : info.bounds.max[1] - 1, info.voxel_m);
    out.zrange = out.zmax - out.zmin;
    return out;
}

std::string to_json(const Origin& origin) {
    std::string out = "{";
    append_number(out, "tmx", origin.tmx);
    append_number(out, "tmy", origin.tmy);
    append_number(out, "tmz", origin.tmz);
    append_number(out, "zmin", origin.zmin);
    append_number(out, "zmax", origin.zmax);
    append_number(out, "zrange", origin.zrange);
    return out + "}";
}

}  // namespace terravox::gkot
