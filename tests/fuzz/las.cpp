// LAS and LAZ files: header, records, chunk table, points, and the index inside (COPC).
#include "common/geo/gdal_messages.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "voxelserver/data/lidar/las_file.hpp"
#include "voxelserver/data/lidar/spatial_index.hpp"

namespace terravox::fuzz {
namespace {

constexpr std::uint64_t kMaxPoints = 1'000'000;

/// A few bytes may stand for many equal points: that takes time, but says nothing new.
struct EnoughPoints {};

void read_points(const lidar::LasInfo& info) {
    std::uint64_t count = 0;
    const auto ranges = lidar::split_by_chunk(info, 20'000);
    try {
        lidar::read_point_batches(info, ranges, [&](std::span<const lidar::RawPoint> batch) {
            count += batch.size();
            if (count > kMaxPoints)
                throw EnoughPoints();
        });
    } catch (const EnoughPoints&) {
        return;
    }
    expect(count == info.point_count, "a file is refused, or all of its points are read");
}

}  // namespace

void run(Input input) {
    const geo::GdalErrorScope errors;
    const auto info = lidar::read_las_info(as_file(input, "input.laz"));
    allow_errors([&] { read_points(info); });
    allow_errors([&] {
        const auto sample = lidar::sample_points(info, 100);
        expect(!sample.empty() || info.point_count == 0, "a file of points has a sample");
    });
    const auto index = lidar::read_spatial_index(info);
    if (!index)
        return;
    const auto all = index->ranges_over(-1e300, -1e300, 1e300, 1e300);
    expect(all.size() == 1 && all[0].begin == 0 && all[0].end == info.point_count,
           "an index holds every point");
}

}  // namespace terravox::fuzz
