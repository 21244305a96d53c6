#include "voxelserver/make/voxelize/points/point_load.hpp"

#include <algorithm>
#include <set>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/fingerprint.hpp"

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
        throw util::Error(
            "read the point cloud {}: it has changed since it was opened; start again",
            source.info.path.string());
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

std::vector<grid::PatchKey> list_patches(const store::PatchedPoints& points) {
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
        chunks[i] = {ranges[i], list_patches(parts[i].points)};
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

namespace {

std::uint64_t count_in_ranges(const std::vector<pointcloud::PointRange>& ranges) {
    std::uint64_t out = 0;
    for (const auto& r : ranges)
        out += r.end - r.begin;
    return out;
}

}  // namespace

PointParts::PointParts(std::vector<PartedFile> files, const LoadContext& context,
                       IndexFolders folders, std::size_t memory_bytes, int threads, Report report)
    : m_files(std::move(files)),
      m_context(context),
      m_folders(folders),
      m_threads(threads),
      m_report(std::move(report)),
      m_parts(memory_bytes) {
    for (std::size_t i = 0; i < m_files.size(); ++i)
        m_states.push_back(std::make_unique<State>());
}

bool PointParts::are_enough(std::size_t file, const grid::PatchRect& wanted) {
    if (m_files[file].source->spatial_index == nullptr && chunk_index(file, false) == nullptr)
        return false;
    const std::uint64_t most = m_files[file].source->info.point_count / 2;
    const std::uint64_t before = m_states[file]->decoded.load();
    return before <= most && before + points_to_decode(file, wanted) <= most;
}

Squares PointParts::around(std::size_t file, const grid::PatchRect& wanted) {
    if (by_chunk(file))
        return load_chunks(file, wanted);
    return {block(to_block(file, wanted))};
}

// Where many chunks hold a few points of each patch, keeping whole chunks would fill the memory
// with points that were not requested.
bool PointParts::prefers_chunks(std::size_t file) {
    const PartedFile& parted = m_files[file];
    const auto& index = parted.source->spatial_index;
    if (index != nullptr && !index->by_chunk())
        return false;
    if (parted.kept_whole)
        return true;
    const grid::ColumnRect& bounds = parted.source->bounds;
    const grid::PatchKey middle{
        voxel::floor_div((bounds.min_x + bounds.max_x) / 2, grid::kPatchSize),
        voxel::floor_div((bounds.min_z + bounds.max_z) / 2, grid::kPatchSize)};
    const grid::PatchRect around{{middle.px - 1, middle.pz - 1}, {middle.px + 2, middle.pz + 2}};
    return 2 * count_in_ranges(chunks_over(file, around)) * sizeof(store::VoxelPoint) <=
           m_parts.limit_bytes();
}

// A mutex, not std::call_once: what is read here may throw, and a thread that waits for such a call
// hangs under the thread sanitizer.
bool PointParts::by_chunk(std::size_t file) {
    State& state = *m_states[file];
    const std::lock_guard lock(state.choosing);
    if (!state.by_chunk)
        state.by_chunk = prefers_chunks(file);
    return *state.by_chunk;
}

std::uint64_t PointParts::points_to_decode(std::size_t file, const grid::PatchRect& wanted) {
    if (by_chunk(file)) {
        std::uint64_t out = 0;
        for (const pointcloud::PointRange& chunk : chunks_over(file, wanted))
            if (m_parts.find(chunk_key(file, chunk)) == nullptr)
                out += chunk.end - chunk.begin;
        return out;
    }
    const PartKey key = to_block(file, wanted);
    return m_parts.find(key) != nullptr ? 0 : count_in_ranges(ranges_over(file, list_patches(key)));
}

Squares PointParts::load_chunks(std::size_t file, const grid::PatchRect& wanted) {
    const auto chunks = chunks_over(file, wanted);
    Squares out(chunks.size());
    thread::parallel_for(chunks.size(), m_threads, [&](std::size_t i) {
        out[i] = m_parts.get(
            chunk_key(file, chunks[i]),
            [&] {
                m_states[file]->decoded += chunks[i].end - chunks[i].begin;
                auto square = load_range(*m_files[file].source, chunks[i], m_context);
                m_report(file, square->counts(), false);
                return square;
            },
            [](const auto& s) { return s->memory_bytes(); });
    });
    return out;
}

PointParts::PartKey PointParts::to_block(std::size_t file,
                                         const grid::PatchRect& wanted) const noexcept {
    const int edge = m_files[file].block_patches;
    return {file,
            {voxel::floor_div((wanted.min.px + wanted.max.px - 1) / 2, edge),
             voxel::floor_div((wanted.min.pz + wanted.max.pz - 1) / 2, edge)}};
}

// A block and the patches around it.
grid::PatchRect PointParts::list_patches(const PartKey& block) const noexcept {
    const int edge = m_files[block.file].block_patches;
    return {{block.part.px * edge - 1, block.part.pz * edge - 1},
            {(block.part.px + 1) * edge + 1, (block.part.pz + 1) * edge + 1}};
}

std::shared_ptr<const store::Square> PointParts::block(const PartKey& key) {
    return m_parts.get(
        key,
        [&] {
            const grid::PatchRect rect = list_patches(key);
            const auto ranges = ranges_over(key.file, rect);
            m_states[key.file]->decoded += count_in_ranges(ranges);
            auto square =
                load_patches(*m_files[key.file].source, ranges, rect, m_context, m_threads);
            m_report(key.file, square->counts(), false);
            return square;
        },
        [](const auto& s) { return s->memory_bytes(); });
}

std::vector<pointcloud::PointRange> PointParts::chunks_over(std::size_t file,
                                                            const grid::PatchRect& wanted) {
    if (const auto& index = m_files[file].source->spatial_index) {
        const Extent extent = measure_extent(wanted);
        return index->cells_over(extent.min_x, extent.min_y, extent.max_x, extent.max_y);
    }
    const auto index = chunk_index(file, true);
    std::vector<pointcloud::PointRange> out;
    for (const std::size_t i : index->over(wanted))
        out.push_back(index->chunks()[i].points);
    return out;
}

std::vector<pointcloud::PointRange> PointParts::ranges_over(std::size_t file,
                                                            const grid::PatchRect& wanted) {
    const auto& index = m_files[file].source->spatial_index;
    if (index == nullptr)
        return chunk_index(file, true)->ranges_over(wanted);
    const Extent extent = measure_extent(wanted);
    return index->ranges_over(extent.min_x, extent.min_y, extent.max_x, extent.max_y);
}

// One voxel more on every side: fixed point rounds down.
PointParts::Extent PointParts::measure_extent(const grid::PatchRect& rect) const noexcept {
    const grid::Frame& frame = m_context.frame;
    return {frame.easting(rect.min.x0() - 1), frame.northing(rect.max.z0() + 1),
            frame.easting(rect.max.x0() + 1), frame.northing(rect.min.z0() - 1)};
}

void PointParts::learn(std::size_t file, store::ChunkIndex index) {
    put_index(m_files[file].name, index);
    const std::lock_guard lock(m_states[file]->index_mutex);
    m_states[file]->chunks = std::make_shared<store::ChunkIndex>(std::move(index));
    m_states[file]->learnt = true;
}

std::shared_ptr<const store::ChunkIndex> PointParts::chunk_index(std::size_t file, bool scan) {
    State& state = *m_states[file];
    const PartedFile& parted = m_files[file];
    const std::lock_guard lock(state.index_mutex);
    if (state.chunks == nullptr)
        if (auto found = find_index(parted.name))
            state.chunks = std::make_shared<store::ChunkIndex>(std::move(*found));
    if (state.chunks == nullptr && scan) {
        if (!state.failed.empty())
            throw util::Error(state.failed);
        util::log_info("{}: too large to be kept whole; its points are looked through once",
                       parted.source->info.path.string());
        store::PointCounts counts;
        try {
            state.chunks = std::make_shared<store::ChunkIndex>(
                scan_chunks(*parted.source, m_context, m_threads, counts));
        } catch (const util::Error& e) {
            state.failed = e.what();
            throw;
        }
        m_report(file, counts, true);
        put_index(parted.name, *state.chunks);
    }
    if (state.chunks != nullptr)
        state.learnt = true;
    return state.chunks;
}

std::optional<store::ChunkIndex> PointParts::find_index(const std::string& name) const {
    std::optional<store::ChunkIndex> out;
    if (m_folders.cache != nullptr)
        out = m_folders.cache->find_index(name);
    if (out && m_folders.kept != nullptr && !m_folders.kept->holds_index(name))
        m_folders.kept->put_index(name, *out);
    if (!out && m_folders.kept != nullptr && m_folders.reads_kept)
        out = m_folders.kept->find_index(name);
    return out;
}

void PointParts::put_index(const std::string& name, const store::ChunkIndex& index) const {
    for (store::SquareFolder* const folder : {m_folders.cache, m_folders.kept})
        if (folder != nullptr)
            folder->put_index(name, index);
}

}  // namespace terravox::voxelize
