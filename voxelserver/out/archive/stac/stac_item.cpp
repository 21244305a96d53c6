#include "voxelserver/out/archive/stac/stac.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>
#include <vector>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "common/voxel/world.hpp"
#include "voxelserver/out/archive/archive_files.hpp"

namespace terravox::stac {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kArchiveType = "application/vnd.terravox.archive";

/// A rectangle of a map, in units of its CRS.
struct MapRect {
    double west = 0;
    double south = 0;
    double east = 0;
    double north = 0;
};

MapRect to_rect(const voxel::WorldInfo& world) {
    const double scale = world.crs_units_per_voxel;
    const auto& [min, max] = world.bounds;
    // z goes south.
    return {min[0] * scale, -max[2] * scale, max[0] * scale, -min[2] * scale};
}

struct Ring {
    std::vector<double> lon_deg;
    std::vector<double> lat_deg;
};

/// The border of a rectangle of a map, counterclockwise from the south-west, closed. Its edges are
/// curves on Earth, so each has more points than its ends.
Ring make_ring(const MapRect& rect, const geo::Crs& crs, const std::string& attempt) {
    constexpr int kPointsOnEdge = 16;
    Ring ring;
    const std::array<std::pair<double, double>, 5> corners{{{rect.west, rect.south},
                                                            {rect.east, rect.south},
                                                            {rect.east, rect.north},
                                                            {rect.west, rect.north},
                                                            {rect.west, rect.south}}};
    for (std::size_t edge = 0; edge + 1 < corners.size(); ++edge)
        for (int i = 0; i < kPointsOnEdge; ++i) {
            const double share = static_cast<double>(i) / kPointsOnEdge;
            ring.lon_deg.push_back(std::lerp(corners[edge].first, corners[edge + 1].first, share));
            ring.lat_deg.push_back(
                std::lerp(corners[edge].second, corners[edge + 1].second, share));
        }
    geo::Transform(crs, geo::Crs::from_text("EPSG:4326")).apply(ring.lon_deg, ring.lat_deg);
    ring.lon_deg.push_back(ring.lon_deg.front());
    ring.lat_deg.push_back(ring.lat_deg.front());
    for (std::size_t i = 1; i < ring.lon_deg.size(); ++i) {
        constexpr double kHalfTurn_deg = 180;
        if (std::abs(ring.lon_deg[i] - ring.lon_deg[i - 1]) > kHalfTurn_deg)
            throw util::Error(attempt +
                              ": its place crosses the antimeridian or holds a pole; allowed: "
                              "places that do not");
    }
    return ring;
}

/// Degrees to about a centimetre: more digits would hang on the version of PROJ.
double rounded(double degrees) {
    constexpr double kSteps = 1e7;
    return std::round(degrees * kSteps) / kSteps;
}

Json make_geometry(const Ring& ring) {
    Json border = Json::array();
    for (std::size_t i = 0; i < ring.lon_deg.size(); ++i)
        border.push_back(Json::array({rounded(ring.lon_deg[i]), rounded(ring.lat_deg[i])}));
    return {{"type", "Polygon"}, {"coordinates", Json::array({std::move(border)})}};
}

std::array<double, 4> measure_bbox(const Ring& ring) {
    const auto [west, east] = std::minmax_element(ring.lon_deg.begin(), ring.lon_deg.end());
    const auto [south, north] = std::minmax_element(ring.lat_deg.begin(), ring.lat_deg.end());
    return {rounded(*west), rounded(*south), rounded(*east), rounded(*north)};
}

/// @return null where the system has no single number of EPSG
Json find_epsg(const std::string& name) {
    constexpr std::string_view kAuthority = "EPSG:";
    constexpr std::size_t kMaxDigits = 9;
    const std::string number =
        name.starts_with(kAuthority) ? name.substr(kAuthority.size()) : std::string();
    const bool is_number = !number.empty() && number.size() <= kMaxDigits &&
                           number.find_first_not_of("0123456789") == std::string::npos;
    return is_number ? Json(std::stoi(number)) : Json(nullptr);
}

/// STAC takes identifiers of SPDX, and "proprietary" for all other licences.
std::string stac_licence(const std::string& licence) {
    static constexpr std::array<std::pair<std::string_view, std::string_view>, 7> kKnown{
        {{"CC BY 4.0", "CC-BY-4.0"},
         {"CC BY-SA 4.0", "CC-BY-SA-4.0"},
         {"CC0", "CC0-1.0"},
         {"CC0 1.0", "CC0-1.0"},
         {"dl-de/zero-2-0", "DL-DE-ZERO-2.0"},
         {"Licence Ouverte 2.0 (Etalab)", "etalab-2.0"},
         {"Licence Ouverte / Etalab 2.0", "etalab-2.0"}}};
    for (const auto& [text, id] : kKnown)
        if (licence == text || licence == id)
            return std::string(id);
    return "proprietary";
}

Json list_properties(const voxel::WorldInfo& world, const archive_tools::Summary& summary,
                     const geo::Crs& crs, const StacTime& time) {
    Json out;
    if (!world.title.empty())
        out["title"] = world.title;
    out["datetime"] = time.is_instant() ? Json(time.start) : Json(nullptr);
    if (!time.is_instant()) {
        out["start_datetime"] = time.start;
        out["end_datetime"] = time.end;
    }
    out["license"] = stac_licence(world.licence);
    out["gsd"] = world.voxel_m;
    out["proj:epsg"] = find_epsg(crs.name());
    out["proj:wkt2"] = crs.wkt();
    const MapRect rect = to_rect(world);
    out["proj:bbox"] = {rect.west, rect.south, rect.east, rect.north};
    out["terravox:voxel_m"] = world.voxel_m;
    out["terravox:levels"] = world.levels;
    out["terravox:heights_m"] = {world.bounds.min[1] * world.voxel_m,
                                 world.bounds.max[1] * world.voxel_m};
    std::uint64_t boxes = 0;
    for (const archive_tools::LevelSummary& level : summary.levels)
        boxes += level.boxes;
    out["terravox:boxes"] = boxes;
    out["terravox:holes"] = summary.holes();
    out["terravox:damage"] = summary.damage;
    if (!world.licence.empty())
        out["terravox:licence"] = world.licence;
    if (!world.attribution.empty())
        out["terravox:attribution"] = world.attribution;
    return out;
}

}  // namespace

StacItem stac_item(const std::filesystem::path& archive, const StacTime& time,
                   const std::string& href, const std::string& collection) {
    const std::string attempt = "stac of " + archive.string();
    const archive_tools::Summary summary = archive_tools::make_summary(archive);
    if (summary.shard.of > 0 || summary.replaced_columns)
        throw util::UsageError(attempt + ": it is a " +
                               (summary.shard.of > 0 ? "shard" : "change") +
                               " of an archive; allowed: archives");
    const voxel::WorldInfo world = voxel::world_from_json(summary.facts, archive.string());
    if (world.crs_wkt.empty())
        throw util::UsageError(attempt + ": it has no CRS; allowed: archives of places on Earth");
    if (world.bounds.empty())
        throw util::UsageError(attempt + ": it is empty; allowed: archives with boxes");
    geo::check_proj_is_usable(attempt);
    const geo::Crs crs = geo::Crs::from_wkt(world.crs_wkt);
    const Ring ring = make_ring(to_rect(world), crs, attempt);
    StacItem out;
    out.id = archive.stem().string();
    out.bbox_deg = measure_bbox(ring);
    out.licence = stac_licence(world.licence);
    out.holes = summary.holes();
    out.json["type"] = "Feature";
    out.json["stac_version"] = kStacVersion;
    out.json["stac_extensions"] = {
        "https://stac-extensions.github.io/projection/v1.1.0/schema.json",
        "https://stac-extensions.github.io/file/v2.1.0/schema.json"};
    out.json["id"] = out.id;
    out.json["geometry"] = make_geometry(ring);
    out.json["bbox"] = out.bbox_deg;
    out.json["properties"] = list_properties(world, summary, crs, time);
    out.json["links"] = Json::array();
    if (!collection.empty()) {
        for (const char* const rel : {"root", "parent", "collection"})
            out.json["links"].push_back(
                stac_link(rel, std::string("./") + kStacCollection, "application/json"));
        out.json["collection"] = collection;
    }
    out.json["assets"]["archive"] = {{"href", href},
                                     {"type", kArchiveType},
                                     {"title", "Box archive"},
                                     {"roles", {"data"}},
                                     {"file:size", summary.file_bytes}};
    return out;
}

Json stac_link(const char* rel, const std::string& href, const char* type) {
    return {{"rel", rel}, {"href", href}, {"type", type}};
}

std::string url_segment(const std::string& name) {
    constexpr std::string_view kUnreserved =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";
    constexpr std::string_view kHex = "0123456789ABCDEF";
    std::string out;
    for (const char c : name) {
        if (kUnreserved.find(c) != std::string_view::npos) {
            out += c;
            continue;
        }
        const auto byte = static_cast<unsigned char>(c);
        out += '%';
        out += kHex[byte >> 4U];
        out += kHex[byte & 15U];
    }
    return out;
}

}  // namespace terravox::stac
