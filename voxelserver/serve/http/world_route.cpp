#include <xxhash.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/voxel/world.hpp"
#include "voxelserver/serve/http/route_answers.hpp"
#include "voxelserver/serve/map/map_tiles.hpp"

namespace terravox::http {
namespace {

using nlohmann::json;
using Point = std::array<double, 3>;

// What the page accepts (docs/formats/site.md).
constexpr std::size_t kMaxText_bytes = 4096;

// Where coarse boxes are made from fine ones: a column is soon made of those so many levels below,
// which are 16.
constexpr int kSoon = 2;
// Of the coarsest level that is requested: each of them is needed for a whole picture.
constexpr std::int64_t kMaxColumns = 1024;

// The first view shows at most so much of the world: what is near is made first.
constexpr double kNear_m = 600;
constexpr double kFov_deg = 45;
// From the south, turned a little so that walls of both directions are seen.
constexpr double kPi = 3.14159265358979323846;
constexpr double kHeading_rad = 20 * kPi / 180;
constexpr double kDown_rad = 30 * kPi / 180;
// Distance from the middle, in widths of what is shown.
constexpr double kAway = 1.1;
// Above what may be under the camera.
constexpr double kClear_m = 10;

// The afternoon of the longest day, as in the ray tracer's default scene.
constexpr std::chrono::year_month_day kDay{std::chrono::year(2026), std::chrono::June,
                                           std::chrono::day(21)};
constexpr double kHour = 16;
constexpr double kDegrees_per_hour = 15;
constexpr double kHour_ms = 3'600'000;

struct Heights {
    double low = 0;
    double high = 0;
};

// Heights that may be solid at a place, as far as that is known without a box, apart from what
// flies over it; nullopt: air.
std::optional<Heights> heights_at(voxel::World& world, double x, double z) {
    const auto find_column = [](double at, int size) {
        return static_cast<std::int32_t>(std::floor(at / size));
    };
    const voxel::ColumnExtent column =
        world.column(0, find_column(x, voxel::kBoxSizeX), find_column(z, voxel::kBoxSizeZ));
    if (column.empty())
        return std::nullopt;
    const voxel::VoxelBounds bounds = world.info().at_typical_heights(world.info().bounds);
    const auto within = [&](std::int32_t by) {
        const double y = static_cast<double>(voxel::kBoxSizeY) * by;
        return std::clamp<double>(y, bounds.min[1], bounds.max[1]);
    };
    return Heights{within(column.by_begin), within(column.by_end)};
}

double middle(const voxel::VoxelBounds& bounds, std::size_t axis) {
    return (static_cast<double>(bounds.min[axis]) + bounds.max[axis]) / 2;
}

double width(const voxel::VoxelBounds& bounds, std::size_t axis) {
    return static_cast<double>(bounds.max[axis]) - bounds.min[axis];
}

/// A view of the middle of the world that shows about `across` voxels of it.
json view(voxel::World& world, const char* name, double across) {
    const voxel::WorldInfo& info = world.info();
    const voxel::VoxelBounds shown = info.camera_bounds();
    const double away = kAway * across;
    const double flat = away * std::cos(kDown_rad);
    Point target{middle(shown, 0), middle(shown, 1), middle(shown, 2)};
    if (const auto ground = heights_at(world, target[0], target[2]))
        target[1] = (ground->low + ground->high) / 2;
    Point position{target[0] - flat * std::sin(kHeading_rad),
                   target[1] + away * std::sin(kDown_rad),
                   target[2] + flat * std::cos(kHeading_rad)};
    if (const auto ground = heights_at(world, position[0], position[2]))
        position[1] = std::max(position[1], ground->high + kClear_m / info.voxel_m);
    return {{"name", name}, {"position", position}, {"target", target}, {"fov_deg", kFov_deg}};
}

json views(voxel::World& world) {
    const voxel::WorldInfo& info = world.info();
    const voxel::VoxelBounds shown = info.camera_bounds();
    const double across = std::max({width(shown, 0), width(shown, 2), 1.0});
    json whole = view(world, "Whole place", across);
    // The page moves it to where its picture, of whatever shape, shows all of this.
    if (!shown.empty())
        whole["frame"] = {{"min", shown.min}, {"max", shown.max}};
    const double near = kNear_m / info.voxel_m;
    if (across <= near)
        return json::array({whole});
    return json::array({view(world, "Start", near), whole});
}

// By the longitude, so that no time zone is needed.
std::int64_t time_ms(const voxel::WorldInfo& info) {
    const auto day = std::chrono::duration_cast<std::chrono::milliseconds>(
        std::chrono::sys_days(kDay).time_since_epoch());
    const double east_h = info.centre ? info.centre->lon_deg / kDegrees_per_hour : 0;
    return day.count() + std::llround((kHour - std::round(east_h)) * kHour_ms);
}

// The page reads no longer texts; /v2/world has them whole.
std::string shortened(const std::string& text) {
    if (text.size() <= kMaxText_bytes)
        return text;
    constexpr const char* kMore = " \u2026";
    std::size_t end = kMaxText_bytes - std::string_view(kMore).size();
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80)
        --end;  // not within a character
    return text.substr(0, end) + kMore;
}

std::int64_t find_columns(const voxel::WorldInfo& info, int level) {
    const voxel::BoxRange range = voxel::boxes_over(info.bounds, level);
    return (std::int64_t{range.max.bx} - range.min.bx) *
           (std::int64_t{range.max.bz} - range.min.bz);
}

bool all_are_cached(Service& service, int level) {
    const voxel::BoxRange range = voxel::boxes_over(service.world.info().bounds, level);
    for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz)
        for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx) {
            const voxel::ColumnExtent column = service.world.column(level, bx, bz);
            for (std::int32_t by = column.by_begin; by < column.by_end; ++by)
                if (!service.boxes.peek({level, bx, by, bz}))
                    return false;
        }
    return true;
}

}  // namespace

int coarsest_for_viewer(Service& service) {
    const voxel::WorldInfo& info = service.world.info();
    const int last = info.levels - 1;
    if (!service.boxes.makes_coarse_from_fine() || info.bounds.empty())
        return last;
    int level = last;
    for (; level > 0 && find_columns(info, level) <= kMaxColumns; --level)
        if (all_are_cached(service, level))
            return std::min(level + kSoon, last);
    while (level < last && (level < kSoon || find_columns(info, level) > kMaxColumns))
        ++level;
    return level;
}

std::string view_place(Service& service) {
    const voxel::WorldInfo& info = service.world.info();
    json place = {{"version", 1},
                  {"title", shortened(info.title)},
                  {"attribution", shortened(info.attribution)},
                  {"licence", shortened(info.licence)},
                  {"archive", {{"server", "../"}, {"coarsest", coarsest_for_viewer(service)}}},
                  {"views", views(service.world)},
                  {"time_ms", time_ms(info)}};
    if (!service.squares().empty())
        place["squares"] = "../v2/squares";
    return place.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

namespace {

// The world in its JSON format, with the address of its map.
std::string world_text(const voxel::WorldInfo& info) {
    auto world = nlohmann::json::parse(voxel::world_to_json(info));
    world["map"] = {{"tile_px", map::kTilePx}, {"zooms", {0, info.levels - 1}}};
    return world.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

}  // namespace

WorldRoute::WorldRoute(const voxel::WorldInfo& info, std::string edition)
    : m_edition(std::move(edition)),
      m_json(world_text(info)),
      m_etag(make_etag(XXH64(m_json.data(), m_json.size(), 0), "w")) {}

Response WorldRoute::answer(const Request& request) const {
    if (etag_matches(request.header("If-None-Match"), m_etag))
        return not_modified(m_etag);
    Response out = reply(200, "application/json", m_json);
    add_validators(out, m_etag);
    if (!m_edition.empty())
        out.add(kEditionHeader, m_edition);
    return out;
}

}  // namespace terravox::http
