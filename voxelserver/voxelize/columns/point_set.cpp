#include "voxelserver/voxelize/columns/point_set.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"

namespace terravox::voxelize {
namespace {

// How the world's memory is shared out between squares, parts of squares and columns; the world
// keeps the rest for boxes. What they leave, a sixth, is what decoding a square takes beside it.
constexpr std::size_t kSquaresShare = 3, kPartsShare = 8, kColumnsShare = 6;
// What one box needs at once: with less, every step would decode again.
constexpr std::size_t kMinParts = std::size_t{8} << 20, kMinColumns = std::size_t{16} << 20;

// Whether a file can be kept whole, and be binned beside that in half as much: small voxels have
// more patches than points.
bool fits(const SquareSource& source, std::size_t limit_bytes) {
    constexpr double kPatchBytes = sizeof(store::PatchEntry), kBinningBytes = 64, kRunBytes = 32,
                     kAround = 16384;
    const double points = static_cast<double>(source.info.point_count);
    const double width = static_cast<double>(source.bounds.max_x) - source.bounds.min_x,
                 depth = static_cast<double>(source.bounds.max_z) - source.bounds.min_z;
    const double patches =
        std::min((width / grid::kPatchSize + 3) * (depth / grid::kPatchSize + 3), points);
    const double spacing = std::sqrt(width * depth / std::max(points, 1.0)),
                 run = std::max(1.0, grid::kPatchSize / (2 * spacing + 1e-3));
    const double limit = static_cast<double>(limit_bytes);
    return points * sizeof(store::VoxelPoint) + patches * kPatchBytes + kAround < limit &&
           patches * kBinningBytes + points / run * kRunBytes < limit / 2;
}

// At least 2 m, and as many points that an empty cell is a void and not bad luck.
int water_cell_voxels(double voxel_m, double density) {
    constexpr double kSmallest_m = 2, kPointsPerCell = 16;
    int cell = 1;
    while (cell < grid::kPatchSize &&
           (cell * voxel_m < kSmallest_m || density * cell * cell < kPointsPerCell))
        cell *= 2;
    return cell;
}

/// Everything but the file that the points of a prepared square depend on.
std::string recipe_of(const SquareSource& source, const grid::Frame& frame,
                      const ClassTable& classes, const Settings& settings) {
    std::string out = "points 2|" + frame.crs().wkt() + "|" + source.info.crs->wkt() + "|";
    for (const double v : {frame.units_per_voxel(), frame.voxel_m(), source.vertical_metres,
                           source.lowest, source.highest})
        out += fmt::format("{}|", v);  // every digit
    for (const bool flag :
         {settings.points.drop_withheld, settings.points.drop_overlap, source.has_colour})
        out += flag ? 'y' : 'n';
    out += std::to_string(source.colour_shift);
    for (const ClassMeaning& m : classes.meaning)
        out += m.role == Role::kDrop ? 'd' : 'k';
    return out;
}

// Looks at the points of all patches: a square that a crash or a bad disk has damaged is made
// again, not used for a while.
bool intact(const store::Square& square) {
    try {
        for (const store::PatchEntry& patch : square.patches())
            static_cast<void>(square.points(patch.key));
    } catch (const util::Error& e) {
        spdlog::warn("{}; it is made again", e.what());
        return false;
    }
    return true;
}

std::string unknown_classes(const store::PointCounts& counts, const ClassTable& classes) {
    constexpr int kNamed = 8;
    std::string out;
    int found = 0;
    for (std::size_t c = 0; c < counts.by_class.size(); ++c) {
        if (counts.by_class[c] == 0 || classes.meaning[c].known)
            continue;
        if (++found <= kNamed)
            out += (out.empty() ? "" : ", ") + std::to_string(c) + " (" +
                   std::to_string(counts.by_class[c]) + " points)";
    }
    return found > kNamed ? out + " and " + std::to_string(found - kNamed) + " more" : out;
}

}  // namespace

PointSet::PointSet(const LidarWorldOptions& options, const Settings& settings,
                   util::StageTimes& times)
    : m_settings(settings),
      m_times(times),
      m_classes(load_class_table(options.classes)),
      m_threads(thread::thread_count(options.threads)),
      m_sources([&] {
          const util::StageTimes::Scope timed(times, "open files");
          return open_sources(options, m_classes, settings);
      }()),
      m_cell_voxels(water_cell_voxels(options.voxel_m, m_sources.density)),
      m_shares(share_out(options.memory_bytes, m_sources)),
      m_squares(m_shares.squares),
      m_columns(std::max(options.memory_bytes / kColumnsShare, kMinColumns)) {
    const auto empty = init_columns({}, m_classes, m_cell_voxels);
    for (water::WaterCell& cell : empty->cells.cells)
        cell.covered = true;
    m_empty = empty;
    if (!options.cache_dir.empty())
        m_folder = std::make_unique<store::SquareFolder>(options.cache_dir / "squares",
                                                         options.cache_bytes);
    plan_files();
    std::vector<PartedFile> files;
    for (const auto& entry : m_entries)
        files.push_back(entry->file);
    m_parts = std::make_unique<PointParts>(
        std::move(files), context(), m_folder.get(), m_shares.parts, m_threads,
        [this](std::size_t file, const store::PointCounts& met, bool whole) {
            whole ? report(file, met) : report_part(file, met);
        });
}

// What is not needed for whole squares goes to parts.
PointSet::Shares PointSet::share_out(std::size_t memory_bytes, const Sources& sources) {
    Shares out{memory_bytes / kSquaresShare, std::max(memory_bytes / kPartsShare, kMinParts)};
    const auto fitting = std::count_if(sources.files.begin(), sources.files.end(),
                                       [&](const SquareSource& s) { return fits(s, out.squares); });
    if (fitting == static_cast<std::ptrdiff_t>(sources.files.size()))
        return out;
    const std::size_t given = fitting == 0 ? out.squares : out.squares / 2;
    return {out.squares - given, out.parts + given};
}

void PointSet::plan_files() {
    for (const SquareSource& source : m_sources.files) {
        auto entry = std::make_unique<Entry>();
        PartedFile& file = entry->file;
        file.source = &source;
        if (m_folder)
            file.name = store::square_name(
                source.info.path, recipe_of(source, m_sources.frame, m_classes, m_settings));
        file.kept_whole = fits(source, m_shares.squares);
        const double width = static_cast<double>(source.bounds.max_x) - source.bounds.min_x,
                     depth = static_cast<double>(source.bounds.max_z) - source.bounds.min_z;
        const double patch_bytes = static_cast<double>(source.info.point_count) *
                                       sizeof(store::VoxelPoint) / std::max(width * depth, 1.0) *
                                       grid::kPatchColumns +
                                   2 * sizeof(store::PatchEntry);
        // A block and the patch around it take a quarter of their share at most, unless a single
        // patch is larger.
        if (!file.kept_whole)
            file.block_patches = std::max(
                1,
                static_cast<int>(std::sqrt(static_cast<double>(m_shares.parts) / 4 / patch_bytes)) -
                    2);
        m_entries.push_back(std::move(entry));
    }
}

Grid<char, Window::kMargin> PointSet::in_bounds(grid::PatchKey middle) const {
    using Area = Grid<char, Window::kMargin>;
    Area out(0);
    for (const SquareSource& s : m_sources.files)
        for (const grid::ColumnRect& island : s.islands) {
            const int x0 = std::max(island.min_x - middle.x0(), Area::kFirst),
                      x1 = std::min(island.max_x - middle.x0(), Area::kLast);
            const int z0 = std::max(island.min_z - middle.z0(), Area::kFirst),
                      z1 = std::min(island.max_z - middle.z0(), Area::kLast);
            for (int z = z0; z < z1 && x0 < x1; ++z)
                std::fill_n(&out.at(x0, z), x1 - x0, char{1});
        }
    return out;
}

bool PointSet::surrounds(const grid::ColumnRect& rect) const noexcept {
    return std::any_of(m_sources.files.begin(), m_sources.files.end(), [&](const SquareSource& s) {
        return std::any_of(s.islands.begin(), s.islands.end(), [&](const grid::ColumnRect& island) {
            return rect.min_x >= island.min_x && rect.max_x <= island.max_x &&
                   rect.min_z >= island.min_z && rect.max_z <= island.max_z;
        });
    });
}

bool PointSet::in_bounds(std::int32_t x, std::int32_t z) const noexcept {
    return std::any_of(m_sources.files.begin(), m_sources.files.end(),
                       [&](const SquareSource& s) { return s.on_island(x, z); });
}

store::PointCounts PointSet::counts() const {
    const std::lock_guard lock(m_counts_mutex);
    return m_counts;
}

Window PointSet::window(grid::PatchKey middle) {
    Window out;
    out.middle = middle;
    const auto key_of = [&](std::size_t i) {
        return grid::PatchKey{middle.px + static_cast<int>(i % 3) - 1,
                              middle.pz + static_cast<int>(i / 3) - 1};
    };
    // Where parts are decoded, one part serves all that are missing.
    grid::PatchRect missing{{middle.px + 2, middle.pz + 2}, {middle.px - 1, middle.pz - 1}};
    for (std::size_t i = 0; i < out.patches.size(); ++i) {
        const grid::PatchKey key = key_of(i);
        if ((out.patches[i] = m_columns.find(key)))
            continue;
        missing.min = {std::min(missing.min.px, key.px), std::min(missing.min.pz, key.pz)};
        missing.max = {std::max(missing.max.px, key.px + 1), std::max(missing.max.pz, key.pz + 1)};
    }
    Held held;
    for (std::size_t i = 0; i < out.patches.size(); ++i)
        if (!out.patches[i])
            out.patches[i] = columns(key_of(i), missing, held);
    return out;
}

std::shared_ptr<const PatchColumns> PointSet::columns(grid::PatchKey key) {
    Held held;
    return columns(key, {key, {key.px + 1, key.pz + 1}}, held);
}

std::shared_ptr<const PatchColumns> PointSet::columns(grid::PatchKey key,
                                                      const grid::PatchRect& wanted, Held& held) {
    return m_columns.get(
        key,
        [&]() -> std::shared_ptr<const PatchColumns> {
            std::vector<PatchPoints> points;
            // A margin of one voxel: a transformed or rounded point may lie just outside its file's
            // bounds.
            const grid::ColumnRect rect = grid::columns_of(key).grown(1);
            for (std::size_t i = 0; i < m_sources.files.size(); ++i) {
                if (!m_sources.files[i].bounds.overlaps(rect))
                    continue;
                Squares& squares = held[i];
                if (squares.empty())
                    squares = squares_around(i, wanted);
                for (const auto& square : squares)
                    if (const auto inside = square->points(key); !inside.empty())
                        points.push_back({inside, m_sources.files[i].has_colour});
            }
            const util::StageTimes::Scope timed(m_times, "column init");
            // Wide extents of nothing (a stray header, the sea) share one patch.
            if (points.empty() && surrounds(grid::columns_of(key)))
                return m_empty;
            auto out = init_columns(points, m_classes, m_cell_voxels);
            for (int z = 0; z < out->cells.side; ++z)
                for (int x = 0; x < out->cells.side; ++x)
                    out->cells.cells[static_cast<std::size_t>(z * out->cells.side + x)].covered =
                        in_bounds(key.x0() + x * m_cell_voxels + m_cell_voxels / 2,
                                  key.z0() + z * m_cell_voxels + m_cell_voxels / 2);
            return out;
        },
        [this](const auto& p) { return p == m_empty ? std::size_t{0} : p->memory_bytes(); });
}

std::pair<SquareState, std::string> PointSet::state_of(std::size_t file) const {
    const Entry& entry = *m_entries[file];
    std::string error;
    bool in_memory = false;
    {
        const std::lock_guard lock(m_counts_mutex);
        error = entry.last_error;
        in_memory = !entry.in_memory.expired();
    }
    if (in_memory || (m_folder && m_folder->holds(entry.file.name)))
        return {SquareState::kPrepared, {}};
    if (!error.empty())
        return {SquareState::kFailed, std::move(error)};
    return {!entry.file.kept_whole && m_parts->knows(file) ? SquareState::kPrepared
                                                           : SquareState::kFetched,
            {}};
}

Squares PointSet::squares_around(std::size_t file, const grid::PatchRect& wanted) {
    try {
        return read_around(file, wanted);
    } catch (const util::Error& e) {
        const std::lock_guard lock(m_counts_mutex);
        m_entries[file]->last_error = e.what();
        throw;
    }
}

Squares PointSet::read_around(std::size_t file, const grid::PatchRect& wanted) {
    const PartedFile& parted = m_entries[file]->file;
    if (!parted.kept_whole)
        return m_parts->around(file, wanted);
    if (auto square = m_squares.find(file))
        return {std::move(square)};
    if ((m_folder && m_folder->holds(parted.name)) || !m_parts->are_enough(file, wanted))
        return {whole(file)};
    return m_parts->around(file, wanted);
}

std::shared_ptr<const store::Square> PointSet::whole(std::size_t file) {
    Entry& entry = *m_entries[file];
    auto found = m_squares.get(
        file,
        [&]() -> std::shared_ptr<const store::Square> {
            if (m_folder)
                if (auto square = m_folder->find(entry.file.name);
                    square && (entry.looked_through || intact(*square))) {
                    entry.looked_through = true;
                    report(file, square->counts());
                    return square;
                }
            // One at a time: each takes all threads, and as much memory again as the square will.
            const std::lock_guard loading(m_loading);
            if (!entry.failed.empty())
                throw util::Error(entry.failed);
            LoadedSquare loaded = [&] {
                try {
                    return load_square(m_sources.files[file], context(), m_threads);
                } catch (const util::Error& e) {
                    entry.failed = e.what();
                    throw;
                }
            }();
            report(file, loaded.square->counts());
            if (!m_folder) {
                m_parts->learn(file, std::move(loaded.index));
                return loaded.square;
            }
            const util::StageTimes::Scope timed(m_times, "square store");
            m_parts->learn(file, std::move(loaded.index));
            return m_folder->put(entry.file.name, std::move(loaded.square));
        },
        [](const auto& s) { return s->memory_bytes(); });
    const std::lock_guard lock(m_counts_mutex);
    entry.in_memory = found;
    return found;
}

void PointSet::report(std::size_t file, const store::PointCounts& counts) {
    std::call_once(m_entries[file]->reported, [&] {
        const std::string path = m_sources.files[file].info.path.string();
        if (counts.wild > 0)
            spdlog::warn("{}: {} stray points, outside the bounds of all others; left out", path,
                         counts.wild);
        const std::string unknown = unknown_classes(counts, m_classes);
        if (!unknown.empty())
            spdlog::warn("{}: classes that the table '{}' does not name: {}; shown as `unknown`",
                         path, m_classes.id, unknown);
        const std::lock_guard lock(m_counts_mutex);
        m_counts.add(counts);
    });
}

// Parts come in the order of the boxes asked for, and some twice: so each thing is said once, and
// not how often it was met.
void PointSet::report_part(std::size_t file, const store::PointCounts& counts) {
    const std::lock_guard lock(m_counts_mutex);
    Entry& entry = *m_entries[file];
    const std::string path = m_sources.files[file].info.path.string();
    if (counts.wild > 0 && !std::exchange(entry.told_wild, true))
        spdlog::warn("{}: stray points, outside the bounds of all others; left out", path);
    for (std::size_t c = 0; c < counts.by_class.size(); ++c)
        if (counts.by_class[c] > 0 && !m_classes.meaning[c].known && !entry.told_class[c]) {
            entry.told_class[c] = true;
            spdlog::warn("{}: class {}, which the table '{}' does not name; shown as `unknown`",
                         path, c, m_classes.id);
        }
}

}  // namespace terravox::voxelize
