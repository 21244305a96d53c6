#include "voxelserver/make/voxelize/points/point_parts.hpp"

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"

namespace terravox::voxelize {
namespace {

std::uint64_t count_of(const std::vector<pointcloud::PointRange>& ranges) {
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
    return {block(block_of(file, wanted))};
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
    return 2 * count_of(chunks_over(file, around)) * sizeof(store::VoxelPoint) <=
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
    const PartKey key = block_of(file, wanted);
    return m_parts.find(key) != nullptr ? 0 : count_of(ranges_over(file, patches_of(key)));
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

PointParts::PartKey PointParts::block_of(std::size_t file,
                                         const grid::PatchRect& wanted) const noexcept {
    const int edge = m_files[file].block_patches;
    return {file,
            {voxel::floor_div((wanted.min.px + wanted.max.px - 1) / 2, edge),
             voxel::floor_div((wanted.min.pz + wanted.max.pz - 1) / 2, edge)}};
}

// A block and the patches around it.
grid::PatchRect PointParts::patches_of(const PartKey& block) const noexcept {
    const int edge = m_files[block.file].block_patches;
    return {{block.part.px * edge - 1, block.part.pz * edge - 1},
            {(block.part.px + 1) * edge + 1, (block.part.pz + 1) * edge + 1}};
}

std::shared_ptr<const store::Square> PointParts::block(const PartKey& key) {
    return m_parts.get(
        key,
        [&] {
            const grid::PatchRect rect = patches_of(key);
            const auto ranges = ranges_over(key.file, rect);
            m_states[key.file]->decoded += count_of(ranges);
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
        const Extent extent = extent_of(wanted);
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
    const Extent extent = extent_of(wanted);
    return index->ranges_over(extent.min_x, extent.min_y, extent.max_x, extent.max_y);
}

// One voxel more on every side: fixed point rounds down.
PointParts::Extent PointParts::extent_of(const grid::PatchRect& rect) const noexcept {
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
