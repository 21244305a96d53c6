#include "voxelserver/data/lidar/spatial_index.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "voxelserver/data/lidar/chunk_table.hpp"
#include "voxelserver/data/lidar/index_sources.hpp"

namespace terravox::lidar {
namespace {

// An index that belongs to another file may happen to have the same number of points. Checks the
// first points of some chunks, which is cheap.
void check_by_points(const LasInfo& info, const SpatialIndex& index) {
    constexpr std::uint64_t kLookUps = 16;
    constexpr std::uint64_t kPointsEach = 16;
    const auto pieces = split_by_chunk(info, 1);
    std::vector<PointRange> firsts;
    for (std::size_t i = 0; i < pieces.size(); i += pieces.size() / kLookUps + 1)
        firsts.push_back({pieces[i].begin, std::min(pieces[i].begin + kPointsEach, pieces[i].end)});
    std::vector<std::uint64_t> numbers;
    for (const PointRange& range : firsts)
        for (std::uint64_t i = range.begin; i < range.end; ++i)
            numbers.push_back(i);
    auto number = numbers.begin();
    read_point_batches(info, firsts, [&](std::span<const RawPoint> batch) {
        for (const RawPoint& p : batch) {
            const double x = p.x * info.scale[0] + info.offset[0];
            const double y = p.y * info.scale[1] + info.offset[1];
            const std::uint64_t wanted = *number++;
            const auto ranges = index.ranges_over(x, y, x, y);
            if (std::none_of(ranges.begin(), ranges.end(), [&](const PointRange& r) {
                    return r.begin <= wanted && wanted < r.end;
                }))
                throw util::Error(
                    "read " + index.source() + ": by it point " + std::to_string(wanted) + " of " +
                    info.path.string() +
                    " lies elsewhere; one of the two is damaged, or they do not belong together");
        }
    });
}

}  // namespace

std::shared_ptr<const SpatialIndex> read_spatial_index(const LasInfo& info) {
    if (info.point_count == 0)
        return nullptr;
    std::shared_ptr<const SpatialIndex> index;
    if (auto copc = read_copc_index(info))
        index = std::make_shared<const SpatialIndex>(
            std::move(copc->cells), "the COPC hierarchy of " + info.path.string(), true);
    else if (auto cells = read_lax_index(info))
        index = std::make_shared<const SpatialIndex>(std::move(*cells),
                                                     lax_path(info.path).string(), false);
    if (index)
        check_by_points(info, *index);
    return index;
}

}  // namespace terravox::lidar
