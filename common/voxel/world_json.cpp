#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "common/util/error.hpp"
#include "common/util/json_text.hpp"
#include "common/util/version.hpp"
#include "common/voxel/facts_json.hpp"
#include "common/voxel/world.hpp"

namespace terravox::voxel {
namespace {

double angle(const nlohmann::json& in, const char* name, double limit_deg) {
    const auto value = in.at(name).get<double>();
    if (!(value >= -limit_deg && value <= limit_deg))
        throw util::Error("read the centre of a world: {} = {:f}; allowed: {} to {}", name, value,
                          static_cast<int>(-limit_deg), static_cast<int>(limit_deg));
    return value;
}

}  // namespace

using nlohmann::json;

json facts_to_json(const WorldInfo& info, int version) {
    json out = {{"version", version},
                {"software", std::string("terravox ") + kVersion},
                {"title", info.title},
                {"voxel_m", info.voxel_m},
                {"crs", info.crs},
                {"crs_wkt", info.crs_wkt},
                {"crs_units_per_voxel", info.crs_units_per_voxel},
                {"licence", info.licence},
                {"attribution", info.attribution}};
    if (info.centre)
        out["centre"] = {{"lat_deg", info.centre->lat_deg},
                         {"lon_deg", info.centre->lon_deg},
                         {"convergence_deg", info.centre->convergence_deg}};
    return out;
}

void read_facts(const json& in, WorldInfo& into) {
    into.title = in.at("title").get<std::string>();
    into.voxel_m = in.at("voxel_m").get<double>();
    into.crs = in.at("crs").get<std::string>();
    into.crs_wkt = in.at("crs_wkt").get<std::string>();
    into.crs_units_per_voxel = in.at("crs_units_per_voxel").get<double>();
    into.licence = in.at("licence").get<std::string>();
    into.attribution = in.at("attribution").get<std::string>();
    if (!in.contains("centre"))
        return;
    const json& centre = in["centre"];
    into.centre = geo::MapPlace{{angle(centre, "lat_deg", 90), angle(centre, "lon_deg", 360)}, 0};
    if (centre.contains("convergence_deg"))
        into.centre->convergence_deg = angle(centre, "convergence_deg", 360);
}

namespace {

/// Limits the number of boxes of the coarsest level, which is the worst-case cost of rays through a
/// world of air: each box takes a cache look-up and some 250 bytes in the cache. Worlds of this
/// project have 2 x 2 columns of them, or, with orthophotos that limit the levels, a few hundred
/// thousand.
void check_size(const WorldInfo& info, const std::function<void(const std::string&)>& fail) {
    constexpr std::int64_t kMaxOnEdge = 16'384;
    constexpr std::int64_t kMaxBoxes = 4'194'304;
    if (info.bounds.empty())
        return;
    const BoxRange range = boxes_over(info.bounds, info.levels - 1);
    const std::array<std::int64_t, 3> boxes{
        range.max.bx - range.min.bx, range.max.by - range.min.by, range.max.bz - range.min.bz};
    std::int64_t all = 1;
    for (const std::int64_t edge : boxes)
        all = edge > kMaxOnEdge || all > kMaxBoxes ? kMaxBoxes + 1 : all * edge;
    if (all > kMaxBoxes)
        fail("levels = " + std::to_string(info.levels) + " for bounds of " +
             std::to_string(boxes[0]) + " x " + std::to_string(boxes[1]) + " x " +
             std::to_string(boxes[2]) +
             " boxes of the coarsest level; allowed: up to 16384 on an edge, 4194304 in all");
}

}  // namespace

std::string world_to_json(const WorldInfo& info) {
    json materials = json::array();
    for (int i = 0; i < kMaterialCount; ++i)
        materials.push_back(std::string(material_name(static_cast<Material>(i))));
    json out = facts_to_json(info, kWorldVersion);
    out["bounds"] = {{"min", info.bounds.min}, {"max", info.bounds.max}};
    out["box"] = {kBoxSizeX, kBoxSizeY, kBoxSizeZ};
    out["levels"] = info.levels;
    out["materials"] = materials;
    if (!info.framed.empty())
        out["framed"] = {{"min", info.framed.min}, {"max", info.framed.max}};
    if (info.typical_heights)
        out["typical_heights"] = {{"min", info.typical_heights->min},
                                  {"max", info.typical_heights->max}};
    return out.dump(-1, ' ', false, json::error_handler_t::replace);
}

WorldInfo world_from_json(const std::string& text, const std::string& origin) {
    const auto fail = [&](const std::string& what) {
        throw util::Error("read the world of {}: {}", origin, what);
    };
    WorldInfo info;
    try {
        const json in = util::parse_json(text);
        if (in.is_discarded())
            fail("not the reply of a voxel server: it is no JSON");
        if (const int version = in.at("version").get<int>(); version != kWorldVersion)
            fail("version " + std::to_string(version) +
                 "; allowed: " + std::to_string(kWorldVersion));
        const auto box = in.at("box").get<std::array<int, 3>>();
        if (box != std::array{kBoxSizeX, kBoxSizeY, kBoxSizeZ})
            fail("boxes of another size than 64 x 256 x 64");
        read_facts(in, info);
        constexpr std::int64_t kFarthest = 1 << 30;
        const auto read_bounds = [&](const json& from, VoxelBounds& into) {
            const auto min = from.at("min").get<std::array<std::int64_t, 3>>();
            const auto max = from.at("max").get<std::array<std::int64_t, 3>>();
            for (std::size_t a = 0; a < 3; ++a) {
                if (min[a] < -kFarthest || max[a] > kFarthest || min[a] > max[a])
                    fail("bounds beyond 2^30 voxels, or upside down");
                into.min[a] = static_cast<std::int32_t>(min[a]);
                into.max[a] = static_cast<std::int32_t>(max[a]);
            }
        };
        read_bounds(in.at("bounds"), info.bounds);
        if (in.contains("framed"))
            read_bounds(in["framed"], info.framed);
        if (in.contains("typical_heights")) {
            const auto min = in["typical_heights"].at("min").get<std::int64_t>();
            const auto max = in["typical_heights"].at("max").get<std::int64_t>();
            if (min < -kFarthest || max > kFarthest || min >= max)
                fail("typical heights beyond 2^30 voxels, or upside down");
            info.typical_heights =
                HeightRange{static_cast<std::int32_t>(min), static_cast<std::int32_t>(max)};
        }
        info.levels = in.at("levels").get<int>();
    } catch (const json::exception& e) {
        fail(std::string("not the reply of a voxel server: ") + e.what());
    }
    if (!(info.voxel_m > 0 && info.voxel_m <= 1000))
        fail("voxel_m = " + std::to_string(info.voxel_m) + "; allowed: above 0, up to 1000");
    if (!(info.crs_units_per_voxel > 0 && std::isfinite(info.crs_units_per_voxel)))
        fail("crs_units_per_voxel is not a positive number");
    if (info.levels < 1 || info.levels > kMaxLevel + 1)
        fail("levels = " + std::to_string(info.levels) + "; allowed: 1 to " +
             std::to_string(kMaxLevel + 1));
    check_size(info, fail);
    return info;
}

}  // namespace terravox::voxel
