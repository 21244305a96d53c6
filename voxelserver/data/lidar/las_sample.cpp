#include <algorithm>

#include "voxelserver/data/lidar/chunk_table.hpp"
#include "voxelserver/data/lidar/index_sources.hpp"
#include "voxelserver/data/lidar/las_file.hpp"

namespace terravox::lidar {
namespace {

constexpr std::size_t kMaxChunks = 64;
/// Limit for a root node, which may be large; takes some hundredths of a second.
constexpr std::uint64_t kMaxDecoded = 100'000;

// The root node of a COPC file holds points from the whole area, which some writers sort by
// position. It holds at least as many as requested.
std::vector<RawPoint> sample_root(const LasInfo& info, PointRange root, std::size_t about) {
    const PointRange read{
        root.begin, std::min(root.end, root.begin + std::max<std::uint64_t>(kMaxDecoded, about))};
    const std::uint64_t stride = (read.end - read.begin) / about;
    std::vector<RawPoint> out;
    std::uint64_t at = 0;
    read_point_batches(info, {&read, 1}, [&](std::span<const RawPoint> batch) {
        for (const RawPoint& point : batch)
            if (at++ % stride == 0)
                out.push_back(point);
    });
    return out;
}

std::vector<PointRange> beginnings(const LasInfo& info, std::size_t about) {
    if (!info.seekable)
        return {{0, std::min<std::uint64_t>(about, info.point_count)}};
    // An uncompressed file has no chunks, so it can be divided anywhere.
    const std::size_t pieces = std::min(kMaxChunks, about);
    std::vector<PointRange> out;
    const std::uint64_t chunks =
        info.chunks ? info.chunks->size() : std::min<std::uint64_t>(pieces, info.point_count);
    const std::uint64_t used = std::min<std::uint64_t>(pieces, chunks);
    const std::uint64_t each = (about + used - 1) / used;
    for (std::uint64_t i = 0; i < used; ++i) {
        const std::uint64_t chunk = i * chunks / used;
        const std::uint64_t begin =
            info.chunks ? info.chunks->first_point[chunk] : chunk * info.point_count / chunks;
        const std::uint64_t end = info.chunks ? info.chunks->first_point[chunk + 1]
                                              : (chunk + 1) * info.point_count / chunks;
        out.push_back({begin, std::min(end, begin + each)});
    }
    return out;
}

}  // namespace

std::vector<RawPoint> sample_points(const LasInfo& info, std::size_t about) {
    if (info.point_count == 0 || about == 0)
        return {};
    // A root with only a few points would be a poor sample of millions.
    if (const auto copc = read_copc_index(info);
        copc && copc->root && copc->root->end - copc->root->begin >= about)
        return sample_root(info, *copc->root, about);
    std::vector<RawPoint> out;
    read_point_batches(info, beginnings(info, about), [&](std::span<const RawPoint> batch) {
        out.insert(out.end(), batch.begin(), batch.end());
    });
    return out;
}

}  // namespace terravox::lidar
