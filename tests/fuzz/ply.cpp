// PLY point clouds: header, vertices as text and as numbers, the CRS of a comment.
#include "common/geo/gdal_messages.hpp"
#include "tests/fuzz/fuzz.hpp"
#include "voxelserver/data/ply/ply_source.hpp"

namespace terravox::fuzz {

void run(Input input) {
    const geo::GdalErrorScope errors;
    const ply::PlySource source(as_file(input, "input.ply"));
    std::uint64_t count = 0;
    const auto parts = source.parts(20'000);
    source.read(parts, [&](std::span<const pointcloud::Point> batch) { count += batch.size(); });
    expect(count == source.info().point_count, "a file is refused, or all of its points are read");
    expect(!source.sample(100).empty() || count == 0, "a file of points has a sample");
}

}  // namespace terravox::fuzz
