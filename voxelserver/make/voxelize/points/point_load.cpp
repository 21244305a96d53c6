#include "voxelserver/make/voxelize/points/point_load.hpp"

#include <algorithm>
#include <set>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/voxel/file_identity.hpp"

namespace terravox::voxelize {
namespace {

// A usual chunk: the finest part of a file that can be read separately; small enough that threads
// finish at about the same time.
constexpr std::uint64_t kPointsPerTask = 50'000;

struct Part {
    store::PatchedPoints points;
    store::PointCounts counts;
};

// If a file has been replaced meanwhile, its points are not those of this world: what is made of
// them would be kept under the old file's name. Once after all parts: each look reads 128 KiB.
void check_unchanged(const SquareSource& source) {
    if (source.identity != voxel::Fingerprint{} &&
        voxel::file_identity(source.info.path, "point cloud") != source.identity)
        throw util::Error("read the point cloud " + source.info.path.string() +
                          ": it has changed since it was opened; start again");
}

Part load_part(const SquareSource& source, std::span<const pointcloud::PointRange> ranges,
               const std::optional<grid::PatchRect>& wanted, const LoadContext& context) {
    Part part;
    Placer placer(source, context.frame, context.classes, context.settings.points);
    util::StageTimes::Scope timed(context.times, "point load");
    if (!wanted) {
        std::uint64_t count = 0;
        for (const auto& r : ranges)
            count += r.end - r.begin;
        part.points.points.reserve(
            static_cast<std::size_t>(std::min<std::uint64_t>(count, 4 * kPointsPerTask)));
    }
    try {
        const pointcloud::PointBatchSink place = [&](std::span<const pointcloud::Point> batch) {
            placer.place(batch, wanted, part.points, part.counts);
        };
        if (source.brightness.is_known())
            source.points->read(ranges, place);
        else
            source.points->read_without_echoes(ranges, place);
    } catch (const util::Error&) {
        check_unchanged(source);  // a change is then the reason
        throw;
    }
    timed.hand_over("transformation", placer.transformation_s());
    timed.hand_over("quantization", placer.quantization_s());
    return part;
}

std::vector<grid::PatchKey> patches_of(const store::PatchedPoints& points) {
    std::vector<grid::PatchKey> out;
    for (const auto& run : points.runs)
        out.push_back(run.patch);
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

std::shared_ptr<const store::Square> bin(std::vector<Part> parts, const LoadContext& context,
                                         int threads) {
    const util::StageTimes::Scope timed(context.times, "binning");
    store::PointCounts counts;
    std::vector<store::PatchedPoints> points;
    points.reserve(parts.size());
    for (Part& part : parts) {
        counts.add(part.counts);
        points.push_back(std::move(part.points));
    }
    return store::bin_points(std::move(points), counts, threads);
}

// Long ranges are cut at chunk borders so that all threads have work.
std::vector<pointcloud::PointRange> cut(const pointcloud::PointSource& points,
                                        std::span<const pointcloud::PointRange> ranges) {
    std::vector<pointcloud::PointRange> out;
    const auto tasks = points.parts(kPointsPerTask);
    for (const pointcloud::PointRange& range : ranges)
        for (auto task = std::lower_bound(tasks.begin(), tasks.end(), range.begin,
                                          [](const pointcloud::PointRange& t, std::uint64_t begin) {
                                              return t.end <= begin;
                                          });
             task != tasks.end() && task->begin < range.end; ++task)
            out.push_back({std::max(task->begin, range.begin), std::min(task->end, range.end)});
    return out;
}

}  // namespace

LoadedSquare load_square(const SquareSource& source, const LoadContext& context, int threads) {
    const auto ranges = source.points->parts(kPointsPerTask);
    std::vector<Part> parts(ranges.size());
    std::vector<store::ChunkIndex::Chunk> chunks(ranges.size());
    thread::parallel_for(ranges.size(), threads, [&](std::size_t i) {
        parts[i] = load_part(source, std::span(&ranges[i], 1), std::nullopt, context);
        chunks[i] = {ranges[i], patches_of(parts[i].points)};
    });
    check_unchanged(source);
    return {bin(std::move(parts), context, threads), store::ChunkIndex(std::move(chunks))};
}

std::shared_ptr<const store::Square> load_patches(const SquareSource& source,
                                                  std::span<const pointcloud::PointRange> ranges,
                                                  const grid::PatchRect& wanted,
                                                  const LoadContext& context, int threads) {
    // Each task takes neighbouring ranges: opening a reader costs as much as decoding some thousand
    // points.
    const auto pieces = cut(*source.points, ranges);
    std::vector<std::pair<std::size_t, std::size_t>> tasks;
    std::uint64_t points = 0;
    for (std::size_t i = 0, begin = 0; i < pieces.size(); ++i) {
        points += pieces[i].end - pieces[i].begin;
        if (points < kPointsPerTask && i + 1 < pieces.size())
            continue;
        tasks.emplace_back(begin, i + 1);
        begin = i + 1;
        points = 0;
    }
    std::vector<Part> parts(tasks.size());
    thread::parallel_for(tasks.size(), threads, [&](std::size_t i) {
        parts[i] = load_part(
            source, std::span(pieces).subspan(tasks[i].first, tasks[i].second - tasks[i].first),
            wanted, context);
    });
    check_unchanged(source);
    return bin(std::move(parts), context, threads);
}

std::shared_ptr<const store::Square> load_range(const SquareSource& source,
                                                const pointcloud::PointRange& range,
                                                const LoadContext& context) {
    std::vector<Part> parts;
    parts.push_back(load_part(source, std::span(&range, 1), std::nullopt, context));
    check_unchanged(source);
    return bin(std::move(parts), context, 1);
}

store::ChunkIndex scan_chunks(const SquareSource& source, const LoadContext& context, int threads,
                              store::PointCounts& counts) {
    const auto ranges = source.points->parts(kPointsPerTask);
    std::vector<store::ChunkIndex::Chunk> chunks(ranges.size());
    std::vector<store::PointCounts> met(ranges.size());
    thread::parallel_for(ranges.size(), threads, [&](std::size_t i) {
        const util::StageTimes::Scope timed(context.times, "point load");
        Placer placer(source, context.frame, context.classes, context.settings.points);
        // A file without chunks is one range: what is kept of it must not grow with its points.
        std::set<grid::PatchKey> patches;
        store::PatchedPoints batch_points;
        source.points->read_without_echoes(
            std::span(&ranges[i], 1), [&](std::span<const pointcloud::Point> batch) {
                placer.place(batch, std::nullopt, batch_points, met[i]);
                for (const auto& run : batch_points.runs)
                    patches.insert(run.patch);
                batch_points.points.clear();
                batch_points.runs.clear();
            });
        chunks[i] = {ranges[i], {patches.begin(), patches.end()}};
    });
    for (const store::PointCounts& c : met)
        counts.add(c);
    return store::ChunkIndex(std::move(chunks));
}

}  // namespace terravox::voxelize
