#include "voxelserver/voxelize/point_set.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"

namespace terravox::voxelize {
namespace {

// How the world's memory is shared out between squares, parts of squares and columns; the world keeps the rest for boxes.
// What they leave, a sixth, is what decoding a square takes beside it.
constexpr std::size_t kSquaresShare = 3, kPartsShare = 8, kColumnsShare = 6;
// What one box needs at once: with less, every step would decode again.
constexpr std::size_t kLeastParts = std::size_t{8} << 20, kLeastColumns = std::size_t{16} << 20;

// At least 2 m, and as many points that an empty cell is a void and not bad luck.
int water_cell_voxels(double voxel_m, double density) {
    constexpr double kSmallest_m = 2, kPointsPerCell = 16;
    int cell = 1;
    while (cell < kPatchSize && (cell * voxel_m < kSmallest_m || density * cell * cell < kPointsPerCell)) cell *= 2;
    return cell;
}

/// Everything but the file that the points of a prepared square depend on.
std::string recipe_of(const SquareSource& source, const Frame& frame, const ClassTable& classes, const Settings& settings) {
    std::string out = "points 1|" + frame.crs().wkt() + "|" + source.info.crs->wkt() + "|";
    for (const double v : {frame.units_per_voxel(), frame.voxel_m(), source.vertical_metres, source.lowest, source.highest}) out += fmt::format("{}|", v);  // every digit
    for (const bool flag : {settings.points.drop_withheld, settings.points.drop_overlap, source.has_colour}) out += flag ? 'y' : 'n';
    out += std::to_string(source.colour_shift);
    for (const ClassMeaning& m : classes.meaning) out += m.role == Role::kDrop ? 'd' : 'k';
    return out;
}

std::uint64_t count_of(const std::vector<lidar::PointRange>& ranges) {
    std::uint64_t out = 0;
    for (const auto& r : ranges) out += r.end - r.begin;
    return out;
}

// Looks at the points of all patches: a square that a crash or a bad disk has damaged is made again, not used for a while.
bool intact(const Square& square) {
    try {
        for (const PatchEntry& patch : square.patches()) static_cast<void>(square.points(patch.key));
    } catch (const Error& e) {
        spdlog::warn("{}; it is made again", e.what());
        return false;
    }
    return true;
}

std::string unknown_classes(const PointCounts& counts, const ClassTable& classes) {
    constexpr int kNamed = 8;
    std::string out;
    int found = 0;
    for (std::size_t c = 0; c < counts.by_class.size(); ++c) {
        if (counts.by_class[c] == 0 || classes.meaning[c].known) continue;
        if (++found <= kNamed) out += (out.empty() ? "" : ", ") + std::to_string(c) + " (" + std::to_string(counts.by_class[c]) + " points)";
    }
    return found > kNamed ? out + " and " + std::to_string(found - kNamed) + " more" : out;
}

}  // namespace

PointSet::PointSet(const LidarWorldOptions& options, const Settings& settings, util::StageTimes& times)
    : m_settings(settings),
      m_times(times),
      m_classes(load_class_table(options.classes)),
      m_threads(thread::thread_count(options.threads)),
      m_sources([&] {
          const util::StageTimes::Scope timed(times, "open files");
          return open_sources(options, m_classes, settings);
      }()),
      m_cell_voxels(water_cell_voxels(options.voxel_m, m_sources.density)),
      m_squares(options.memory_bytes / kSquaresShare),
      m_parts(std::max(options.memory_bytes / kPartsShare, kLeastParts)),
      m_columns(std::max(options.memory_bytes / kColumnsShare, kLeastColumns)) {
    const auto empty = init_columns({}, m_classes, m_cell_voxels);
    for (water::WaterCell& cell : empty->cells.cells) cell.covered = true;
    m_empty = empty;
    if (!options.cache_dir.empty()) m_folder = std::make_unique<store::SquareFolder>(options.cache_dir / "squares", options.cache_bytes);
    for (const SquareSource& source : m_sources.files) {
        auto entry = std::make_unique<Entry>();
        if (m_folder) entry->name = store::square_name(source.info, recipe_of(source, m_sources.frame, m_classes, settings));
        const double bytes = static_cast<double>(source.info.point_count) * sizeof(VoxelPoint);
        const double width = static_cast<double>(source.bounds.max_x) - source.bounds.min_x, depth = static_cast<double>(source.bounds.max_z) - source.bounds.min_z;
        // With its directory and what the cache adds: one that is made but not kept would be made for every patch.
        constexpr double kAround = 16384;
        const double directory = (width / kPatchSize + 3) * (depth / kPatchSize + 3) * sizeof(PatchEntry);
        entry->kept_whole = bytes + directory + kAround < static_cast<double>(m_squares.limit_bytes());
        const double area = width * depth;
        // A block and the patch around it take a quarter of their share at most, unless a single patch is larger.
        const double patches = static_cast<double>(m_parts.limit_bytes()) / 4 / std::max(bytes / area * kPatchColumns, 1.0);
        if (!entry->kept_whole) entry->block_patches = std::max(1, static_cast<int>(std::sqrt(patches)) - 2);
        m_entries.push_back(std::move(entry));
    }
}

Grid<char, Window::kMargin> PointSet::in_bounds(PatchKey middle) const {
    using Area = Grid<char, Window::kMargin>;
    Area out(0);
    for (const SquareSource& s : m_sources.files) {
        const int x0 = std::max(s.bounds.min_x - middle.x0(), Area::kFirst), x1 = std::min(s.bounds.max_x - middle.x0(), Area::kLast);
        const int z0 = std::max(s.bounds.min_z - middle.z0(), Area::kFirst), z1 = std::min(s.bounds.max_z - middle.z0(), Area::kLast);
        for (int z = z0; z < z1 && x0 < x1; ++z) std::fill_n(&out.at(x0, z), x1 - x0, char{1});
    }
    return out;
}

bool PointSet::surrounds(const ColumnRect& rect) const noexcept {
    return std::any_of(m_sources.files.begin(), m_sources.files.end(), [&](const SquareSource& s) {
        return rect.min_x >= s.bounds.min_x && rect.max_x <= s.bounds.max_x && rect.min_z >= s.bounds.min_z && rect.max_z <= s.bounds.max_z;
    });
}

bool PointSet::in_bounds(std::int32_t x, std::int32_t z) const noexcept {
    return std::any_of(m_sources.files.begin(), m_sources.files.end(), [&](const SquareSource& s) {
        return x >= s.bounds.min_x && x < s.bounds.max_x && z >= s.bounds.min_z && z < s.bounds.max_z;
    });
}

PointCounts PointSet::counts() const {
    const std::lock_guard lock(m_counts_mutex);
    return m_counts;
}

Window PointSet::window(PatchKey middle) {
    Window out;
    out.middle = middle;
    // The middle first: where parts are decoded, its part serves the others.
    constexpr int kOrder[9] = {4, 0, 1, 2, 3, 5, 6, 7, 8};
    Held held;
    for (const int i : kOrder) out.patches[static_cast<std::size_t>(i)] = columns({middle.px + i % 3 - 1, middle.pz + i / 3 - 1}, middle, held);
    return out;
}

std::shared_ptr<const PatchColumns> PointSet::columns(PatchKey key) {
    Held held;
    return columns(key, key, held);
}

std::shared_ptr<const PatchColumns> PointSet::columns(PatchKey key, PatchKey centre, Held& held) {
    return m_columns.get(
        key,
        [&]() -> std::shared_ptr<const PatchColumns> {
            std::vector<PatchPoints> points;
            // A margin of one voxel: a transformed or rounded point may lie just outside its file's bounds.
            const ColumnRect rect = columns_of(key).grown(1);
            for (std::size_t i = 0; i < m_sources.files.size(); ++i) {
                if (!m_sources.files[i].bounds.overlaps(rect)) continue;
                auto& square = held[i];
                if (!square) square = points_around(i, centre);
                const auto inside = square->points(key);
                if (!inside.empty()) points.push_back({inside, m_sources.files[i].has_colour});
            }
            const util::StageTimes::Scope timed(m_times, "column init");
            // Wide extents of nothing (a stray header, the sea) share one patch.
            if (points.empty() && surrounds(columns_of(key))) return m_empty;
            auto out = init_columns(points, m_classes, m_cell_voxels);
            for (int z = 0; z < out->cells.side; ++z)
                for (int x = 0; x < out->cells.side; ++x)
                    out->cells.cells[static_cast<std::size_t>(z * out->cells.side + x)].covered =
                        in_bounds(key.x0() + x * m_cell_voxels + m_cell_voxels / 2, key.z0() + z * m_cell_voxels + m_cell_voxels / 2);
            return out;
        },
        [this](const auto& p) { return p == m_empty ? std::size_t{0} : p->memory_bytes(); });
}

std::shared_ptr<const Square> PointSet::points_around(std::size_t file, PatchKey centre) {
    if (m_entries[file]->kept_whole) {
        if (auto square = m_squares.find(file)) return square;
        if (!part_is_enough(file, centre)) return whole(file);
    }
    return part(file, centre);
}

std::shared_ptr<const Square> PointSet::whole(std::size_t file) {
    Entry& entry = *m_entries[file];
    return m_squares.get(
        file,
        [&]() -> std::shared_ptr<const Square> {
            if (m_folder)
                if (auto square = m_folder->find(entry.name); square && (entry.looked_through || intact(*square))) {
                    entry.looked_through = true;
                    report(file, square->counts());
                    return square;
                }
            // One at a time: each takes all threads, and as much memory again as the square will.
            const std::lock_guard loading(m_loading);
            LoadedSquare loaded = load_square(m_sources.files[file], context(), m_threads);
            report(file, loaded.square->counts());
            if (m_folder) {
                const util::StageTimes::Scope timed(m_times, "square store");
                m_folder->put_index(entry.name, loaded.index);
                loaded.square = m_folder->put(entry.name, std::move(loaded.square));
            }
            const std::lock_guard lock(entry.index_mutex);
            entry.chunks = std::make_shared<ChunkIndex>(std::move(loaded.index));
            return loaded.square;
        },
        [](const auto& s) { return s->memory_bytes(); });
}

// Parts are worth it while something tells where the points lie, the whole is not on disk, and with this part less than half will have been
// decoded.
bool PointSet::part_is_enough(std::size_t file, PatchKey centre) {
    Entry& entry = *m_entries[file];
    const std::uint64_t most = m_sources.files[file].info.point_count / 2, before = entry.decoded_in_parts.load();
    if (before > most || (m_folder && m_folder->holds(entry.name))) return false;
    if (m_sources.files[file].spatial_index == nullptr && chunk_index(file, false) == nullptr) return false;
    return m_parts.find(block_of(file, centre)) != nullptr || before + count_of(ranges_over(file, patches_of(file, centre))) <= most;
}

PointSet::BlockKey PointSet::block_of(std::size_t file, PatchKey centre) const {
    const int edge = m_entries[file]->block_patches;
    return {file, {voxel::floor_div(centre.px, edge), voxel::floor_div(centre.pz, edge)}};
}

// A block and the patches around it.
PatchRect PointSet::patches_of(std::size_t file, PatchKey centre) const {
    const int edge = m_entries[file]->block_patches;
    const PatchKey block = block_of(file, centre).block;
    return {{block.px * edge - 1, block.pz * edge - 1}, {(block.px + 1) * edge + 1, (block.pz + 1) * edge + 1}};
}

std::shared_ptr<const Square> PointSet::part(std::size_t file, PatchKey centre) {
    Entry& entry = *m_entries[file];
    return m_parts.get(
        block_of(file, centre),
        [&] {
            const PatchRect rect = patches_of(file, centre);
            const auto ranges = ranges_over(file, rect);
            entry.decoded_in_parts += count_of(ranges);
            auto square = load_patches(m_sources.files[file], ranges, rect, context(), m_threads);
            const PointCounts& counts = square->counts();
            if (counts.wild > 0 || !unknown_classes(counts, m_classes).empty()) report(file, counts);
            return square;
        },
        [](const auto& s) { return s->memory_bytes(); });
}

std::vector<lidar::PointRange> PointSet::ranges_over(std::size_t file, const PatchRect& rect) {
    const SquareSource& source = m_sources.files[file];
    if (source.spatial_index == nullptr) return chunk_index(file, true)->ranges_over(rect);
    // One voxel more on every side: fixed point cuts off downwards.
    const Frame& frame = m_sources.frame;
    return source.spatial_index->ranges_over(frame.easting(rect.min.x0() - 1), frame.northing(rect.max.z0() + 1), frame.easting(rect.max.x0() + 1),
                                             frame.northing(rect.min.z0() - 1));
}

std::shared_ptr<const ChunkIndex> PointSet::chunk_index(std::size_t file, bool scan) {
    Entry& entry = *m_entries[file];
    const std::lock_guard lock(entry.index_mutex);
    if (entry.chunks == nullptr && m_folder)
        if (auto found = m_folder->find_index(entry.name)) entry.chunks = std::make_shared<ChunkIndex>(std::move(*found));
    if (entry.chunks == nullptr && scan) {
        spdlog::info("{}: too large to be kept whole; its points are looked through once", m_sources.files[file].info.path.string());
        PointCounts counts;
        entry.chunks = std::make_shared<ChunkIndex>(scan_chunks(m_sources.files[file], context(), m_threads, counts));
        report(file, counts);
        if (m_folder) m_folder->put_index(entry.name, *entry.chunks);
    }
    return entry.chunks;
}

void PointSet::report(std::size_t file, const PointCounts& counts) {
    std::call_once(m_entries[file]->reported, [&] {
        const std::string path = m_sources.files[file].info.path.string();
        if (counts.wild > 0) spdlog::warn("{}: {} points far outside the bounds in its header or far from all others; left out", path, counts.wild);
        const std::string unknown = unknown_classes(counts, m_classes);
        if (!unknown.empty()) spdlog::warn("{}: classes that the table '{}' does not name: {}; shown as `unknown`", path, m_classes.id, unknown);
        const std::lock_guard lock(m_counts_mutex);
        m_counts.add(counts);
    });
}

}  // namespace terravox::voxelize
