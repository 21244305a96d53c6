#include "voxelserver/make/voxelize/points/file_crs.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <cstdint>
#include <map>
#include <set>
#include <span>
#include <string>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "voxelserver/make/voxelize/points/square_sample.hpp"

namespace terravox::voxelize {
namespace {

constexpr double kBeside_m = 50;  // some surveys add a margin to their squares

// How far the stated bounds of a file reach beyond a square.
double reach_beyond(const pointcloud::PointCloudInfo& info, const grid::NamedSquare& square) {
    return std::max({square.west - info.min[0], info.max[0] - square.east,
                     square.south - info.min[1], info.max[1] - square.north});
}

// Whether the points of a file lie on a square, but for strays.
bool lie_on(const pointcloud::PointSource& points, const grid::NamedSquare& square) {
    constexpr std::uint64_t kStrays = 100;  // one of so many, as drop_strays() has it
    std::uint64_t all = 0;
    std::uint64_t beside = 0;
    look_over(points, [&](std::span<const pointcloud::Point> batch) {
        all += batch.size();
        for (const pointcloud::Point& p : batch)
            beside += p.x < square.west - kBeside_m || p.x > square.east + kBeside_m ||
                              p.y < square.south - kBeside_m || p.y > square.north + kBeside_m
                          ? 1
                          : 0;
    });
    return all > 0 && beside <= all / kStrays;
}

// The square that a file's name states, where its points lie on it: a name alone is no evidence.
std::optional<grid::NamedSquare> find_square(const SquareSource& file,
                                             const grid::SquareNames& names) {
    const pointcloud::PointCloudInfo& info = file.info;
    auto square = names.find_square(info.path);
    if (!square)
        return std::nullopt;
    const double beyond = reach_beyond(info, *square);
    if (beyond <= kBeside_m)
        return square;
    // Bounds that reach over a whole square more are those of strays, or of a wrong header: the
    // points tell, which take longer. A wide margin is not looked at, since all squares have it.
    const bool meets = info.min[0] <= square->east && info.max[0] >= square->west &&
                       info.min[1] <= square->north && info.max[1] >= square->south;
    if (!meets || beyond <= square->east - square->west || !lie_on(*file.points, *square))
        return std::nullopt;
    return square;
}

}  // namespace

void use_recorded_crs(std::vector<SquareSource>& files, const LidarWorldOptions& options) {
    // Thousands of squares have the same one, and making it takes longer than all else.
    std::map<std::string, geo::Crs> by_text;
    for (SquareSource& file : files) {
        if (file.info.crs)
            continue;
        const auto recorded = options.recorded_crs.find(file.info.path);
        if (recorded == options.recorded_crs.end())
            continue;
        auto crs = by_text.find(recorded->second);
        if (crs == by_text.end())
            crs = by_text.emplace(recorded->second, geo::Crs::from_text(recorded->second)).first;
        file.info.crs = crs->second;
    }
}

std::vector<std::optional<grid::NamedSquare>> list_squares(const std::vector<SquareSource>& files,
                                                           const LidarWorldOptions& options) {
    std::vector<std::optional<grid::NamedSquare>> out(files.size());
    const bool without_crs =
        !options.crs && std::any_of(files.begin(), files.end(),
                                    [](const SquareSource& file) { return !file.info.crs; });
    if (!without_crs && options.orthophotos.empty() && options.classes != kAnyClassTable)
        return out;
    const auto names = grid::SquareNames::load(util::config_dir() / "sources");
    std::transform(files.begin(), files.end(), out.begin(),
                   [&](const SquareSource& file) { return find_square(file, names); });
    return out;
}

void settle_crs(std::vector<SquareSource>& files, const LidarWorldOptions& options,
                const std::vector<std::optional<grid::NamedSquare>>& squares) {
    std::optional<geo::Crs> fixed;
    std::optional<geo::Crs> fallback;
    if (options.crs)
        fixed = geo::Crs::from_text(*options.crs);
    if (options.classes != kAnyClassTable)
        if (const auto crs = load_class_table(options.classes).crs)
            fallback = geo::Crs::from_text(*crs);
    std::map<std::string, std::vector<std::string>> by_name;  // files by what their names state
    for (std::size_t i = 0; i < files.size(); ++i) {
        pointcloud::PointCloudInfo& info = files[i].info;
        if (fixed)
            info.crs = fixed;
        if (!info.crs && squares[i]) {
            info.crs = geo::Crs::from_text(squares[i]->crs);
            by_name[squares[i]->crs + ", as source " + squares[i]->source + " names its squares"]
                .push_back(info.path.filename().string());
        }
        if (!info.crs)
            info.crs = fallback;
        if (!info.crs)
            throw util::UsageError(
                "place the point cloud {}: {}, and neither its name nor a class table tells one; "
                "give one with --crs EPSG:<code>",
                info.path.string(),
                info.crs_fault.empty() ? "the file carries no coordinate reference system"
                                       : "it cannot be placed (" + info.crs_fault + ")");
    }
    for (const auto& [crs, names] : by_name)
        util::log_info("{}{}: no CRS in the file; taken to be in {}", names.front(),
                       names.size() > 1 ? fmt::format(" (one of {} such)", names.size()) : "", crs);
}

namespace {

// Programs spell one name in many ways: "NGF-IGN69", "NGF - IGN69".
std::string plain(const std::string& name) {
    std::string out;
    for (const char c : name)
        if (std::isalnum(static_cast<unsigned char>(c)) != 0)
            out += util::lower_case(c);
    return out;
}

}  // namespace

void warn_of_mixed_datums(std::span<const pointcloud::PointCloudInfo> infos) {
    constexpr std::size_t kNamed = 4;
    std::set<std::string> seen;
    std::string named;
    for (const pointcloud::PointCloudInfo& info : infos) {
        const auto datum = info.crs ? info.crs->vertical_datum() : std::nullopt;
        if (!datum || !seen.insert(plain(*datum)).second || seen.size() > kNamed)
            continue;
        named += (named.empty() ? "" : ", ") + info.path.string() + " from '" + *datum + "'";
    }
    if (seen.size() < 2)
        return;
    if (seen.size() > kNamed)
        named += " and " + std::to_string(seen.size() - kNamed) + " more";
    util::log_warn(
        "heights are measured from different datums and not converted, so files may not meet: {}; "
        "--crs sets one for all files",
        named);
}

}  // namespace terravox::voxelize
