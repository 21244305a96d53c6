#include "tests/bench/entries/data_sets.hpp"

#include <atomic>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "tests/voxelserver/data/lidar/read_points.hpp"

namespace terravox::bench {
namespace {

constexpr std::uint64_t kPointsPerPiece = 100'000;

std::vector<std::filesystem::path> inside(const std::filesystem::path& folder,
                                          const std::vector<std::string>& names) {
    std::vector<std::filesystem::path> out;
    for (const std::string& name : names)
        out.push_back(folder / name);
    return out;
}

std::vector<std::string> montpellier_files() {
    std::vector<std::string> out;
    for (const char* x : {"77050", "77055", "77060"})
        for (const char* y : {"627755", "627760"})
            out.push_back(std::string("ign-pdal-tools/test_data_") + x + "_" + y +
                          "_LA93_IGN69.laz");
    return out;
}

}  // namespace

std::vector<std::filesystem::path> DataSet::paths(const Context& context) const {
    return inside(context.data, files);
}
std::vector<std::filesystem::path> DataSet::orthophoto_paths(const Context& context) const {
    return inside(context.data, orthophotos);
}

std::string DataSet::missing(const Context& context) const {
    auto all = paths(context);
    for (const auto& photo : orthophoto_paths(context))
        all.push_back(photo);
    for (const auto& path : all) {
        std::error_code ignored;
        if (!std::filesystem::is_regular_file(path, ignored))
            return "no " + path.lexically_relative(context.data).string() + " in " +
                   context.data.string() + " (--data)";
    }
    return {};
}

const DataSet& delft() {
    static const DataSet set{"delft",
                             "2 files, 848,942 points, 264 x 228 m",
                             {"tudelft-3dfier-ahn3/ahn3/ahn3_cropped_1.laz",
                              "tudelft-3dfier-ahn3/ahn3/ahn3_cropped_2.laz"},
                             {},
                             "EPSG:28992",
                             "nl-ahn",
                             1};
    return set;
}

const DataSet& montpellier() {
    static const DataSet set{"montpellier",
                             "6 files, 405,937 points, 150 x 100 m",
                             montpellier_files(),
                             {"ign-pdal-tools/color/test_data_rgb.tif"},
                             "",
                             "fr-lidarhd",
                             0.5};
    return set;
}

const DataSet& square() {
    static const DataSet set{"square",
                             "TM_462_101.laz, 7,431,607 points, 1 km2",
                             {"bench/TM_462_101.laz"},
                             {},
                             "EPSG:3794",
                             "si-lss",
                             1};
    return set;
}

DecodeFloor::DecodeFloor(const std::vector<std::filesystem::path>& files) {
    for (const auto& file : files) {
        m_files.push_back(lidar::read_las_info(file));
        m_points += m_files.back().point_count;
        for (const auto& range : lidar::split_by_chunk(m_files.back(), kPointsPerPiece))
            m_pieces.push_back({m_files.size() - 1, range});
    }
}

double DecodeFloor::seconds(int threads) const {
    std::atomic<std::uint64_t> decoded{0};
    const double out = measure_seconds([&] {
        thread::parallel_for(m_pieces.size(), threads, [&](std::size_t i) {
            std::uint64_t mine = 0;
            lidar::read_las_points(m_files[m_pieces[i].file], m_pieces[i].range,
                                   [&](const pointcloud::Point&) { ++mine; });
            decoded += mine;
        });
    });
    if (decoded != m_points)
        throw util::Error("decode the files: " + std::to_string(decoded) +
                          " points; their headers promise " + std::to_string(m_points));
    return out;
}

OpenWorld open_data_set(const DataSet& set, const Context& context, int threads) {
    voxelize::LidarWorldOptions options;
    options.files = set.paths(context);
    options.orthophotos = set.orthophoto_paths(context);
    options.classes = set.classes;
    if (!set.crs.empty())
        options.crs = set.crs;
    options.voxel_m = set.voxel_m;
    options.threads = threads;
    OpenWorld out;
    out.times = std::make_unique<util::StageTimes>();
    out.world = voxelize::open_lidar_world(options, *out.times);
    return out;
}

std::vector<voxel::BoxKey> box_keys(voxel::World& world) {
    std::vector<voxel::BoxKey> out;
    const auto range = voxel::boxes_over(world.info().bounds, 0);
    for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz)
        for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx) {
            const auto extent = world.column(0, bx, bz);
            for (std::int32_t by = extent.by_begin; by < extent.by_end; ++by)
                out.push_back({0, bx, by, bz});
        }
    return out;
}

}  // namespace terravox::bench
