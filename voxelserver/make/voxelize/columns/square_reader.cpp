#include "voxelserver/make/voxelize/columns/square_reader.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <bitset>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"

namespace terravox::voxelize {
namespace {

constexpr std::size_t kSquaresShare = 3;
constexpr std::size_t kPartsShare = 8;
constexpr std::size_t kColumnsShare = 6;
// The memory that one box needs: with less, every step would decode again.
constexpr std::size_t kMinParts = std::size_t{8} << 20;
constexpr std::size_t kMinColumns = std::size_t{16} << 20;

double measure_width(const SquareSource& source) {
    return static_cast<double>(source.bounds.max_x) - source.bounds.min_x;
}
double find_depth(const SquareSource& source) {
    return static_cast<double>(source.bounds.max_z) - source.bounds.min_z;
}

// Whether a file can be kept whole, and binned in half as much additional memory: small voxels have
// more patches than points.
bool fits(const SquareSource& source, std::size_t limit_bytes) {
    constexpr double kPatchBytes = sizeof(store::PatchEntry);
    constexpr double kBinningBytes = 64;
    constexpr double kRunBytes = 32;
    constexpr double kAround = 16384;
    const auto points = static_cast<double>(source.info.point_count);
    const double width = measure_width(source);
    const double depth = find_depth(source);
    const double patches =
        std::min((width / grid::kPatchSize + 3) * (depth / grid::kPatchSize + 3), points);
    const double spacing = std::sqrt(width * depth / std::max(points, 1.0));
    const double run = std::max(1.0, grid::kPatchSize / (2 * spacing + 1e-3));
    const auto limit = static_cast<double>(limit_bytes);
    return points * sizeof(store::VoxelPoint) + patches * kPatchBytes + kAround < limit &&
           patches * kBinningBytes + points / run * kRunBytes < limit / 2;
}

/// CRSs as text. Writing one takes longer than all else, and thousands of files have the same one.
class CrsTexts {
public:
    const std::string& of(const geo::Crs& crs) {
        const auto [text, is_new] = m_texts.try_emplace(&crs.ogr());
        if (is_new)
            text->second = crs.wkt();
        return text->second;
    }

private:
    std::map<const OGRSpatialReference*, std::string> m_texts;
};

std::string recipe_text(const SquareSource& source, const SquareRecipe& recipe, CrsTexts& crs) {
    const grid::Frame& frame = recipe.frame;
    const Settings::Points& filters = recipe.settings.points;
    std::string out = "points 3|" + crs.of(frame.crs()) + "|" + crs.of(*source.info.crs) + "|";
    for (const double v : {frame.units_per_voxel(), frame.voxel_m(), source.vertical_metres,
                           source.lowest, source.highest})
        out += fmt::format("{}|", v);  // every digit
    for (const bool flag : {filters.drop_withheld, filters.drop_overlap, source.has_colour})
        out += flag ? 'y' : 'n';
    out += std::to_string(source.colour_shift);
    for (const BrightnessScale::Line& line : source.brightness.lines())
        out += fmt::format("|{}:{}", line.number, line.bright_ground);
    for (const ClassMeaning& m : recipe.classes.meaning)
        out += m.role == Role::kDrop ? 'd' : 'k';
    return out;
}

// A block and the patches around it take at most a quarter of their share, unless a single patch is
// larger.
int count_block_patches(const SquareSource& source, std::size_t parts_bytes) {
    const double columns = std::max(measure_width(source) * find_depth(source), 1.0);
    const double patch_bytes = static_cast<double>(source.info.point_count) *
                                   sizeof(store::VoxelPoint) / columns * grid::kPatchColumns +
                               2 * sizeof(store::PatchEntry);
    const double patches = static_cast<double>(parts_bytes) / 4 / patch_bytes;
    return std::max(1, static_cast<int>(std::sqrt(patches)) - 2);
}

}  // namespace

PointMemory share_memory(std::size_t memory_bytes, std::span<const SquareSource> files) {
    PointMemory out{memory_bytes / kSquaresShare, std::max(memory_bytes / kPartsShare, kMinParts),
                    std::max(memory_bytes / kColumnsShare, kMinColumns)};
    const auto fitting = std::count_if(files.begin(), files.end(),
                                       [&](const SquareSource& s) { return fits(s, out.squares); });
    if (fitting == static_cast<std::ptrdiff_t>(files.size()))
        return out;
    const std::size_t given = fitting == 0 ? out.squares : out.squares / 2;
    out.squares -= given;
    out.parts += given;
    return out;
}

std::vector<PartedFile> plan_files(std::span<const SquareSource> files, const PointMemory& memory,
                                   const SquareRecipe* recipe) {
    std::vector<PartedFile> out;
    CrsTexts crs;
    for (const SquareSource& source : files) {
        PartedFile file;
        file.source = &source;
        if (recipe != nullptr)
            file.name = store::square_name(source.info.path, source.identity,
                                           recipe_text(source, *recipe, crs));
        file.kept_whole = fits(source, memory.squares);
        if (!file.kept_whole)
            file.block_patches = count_block_patches(source, memory.parts);
        out.push_back(std::move(file));
    }
    return out;
}

namespace {

std::bitset<256> unknown_codes(const store::PointCounts& counts, const ClassTable& classes) {
    std::bitset<256> out;
    for (std::size_t c = 0; c < counts.by_class.size(); ++c)
        out[c] = counts.by_class[c] > 0 && !classes.meaning[c].known;
    return out;
}

constexpr const char* kStray = "stray points, outside the bounds of all others; left out";

std::string to_list(const std::bitset<256>& codes) {
    constexpr int kNamed = 8;
    std::string out;
    int found = 0;
    for (std::size_t c = 0; c < codes.size(); ++c)
        if (codes[c] && ++found <= kNamed)
            out += (out.empty() ? "" : ", ") + std::to_string(c);
    return found > kNamed ? fmt::format("{} and {} more", out, found - kNamed) : out;
}

/// What is said of classes that the table does not name.
std::string describe_unknown(const std::bitset<256>& codes, const ClassTable& classes) {
    const bool guessed =
        std::any_of(classes.meaning.begin(), classes.meaning.end(),
                    [](const ClassMeaning& m) { return !m.known && m.role == Role::kSurface; });
    const std::string tables = tables_that_name(codes);
    return fmt::format("points of classes that the class table {} does not name ({}): {}{}",
                       classes.id, to_list(codes),
                       guessed ? "guessed like points without a class; --mark-unknown shows them"
                               : "shown in magenta",
                       tables.empty() ? "" : "; --classes that names them: " + tables);
}

}  // namespace

LoadReport::LoadReport(std::span<const SquareSource> files, const ClassTable& classes)
    : m_files(files), m_classes(classes), m_logged(files.size()) {}

void LoadReport::add_whole(std::size_t file, const store::PointCounts& counts) {
    std::call_once(m_logged[file].whole, [&] {
        const std::string path = m_files[file].info.path.string();
        if (counts.outliers > 0)
            util::warn_of_file(path, kStray, std::to_string(counts.outliers) + " points");
        const std::lock_guard lock(m_mutex);
        warn_of_classes(file, counts);
        m_counts.add(counts);
    });
}

void LoadReport::add_part(std::size_t file, const store::PointCounts& counts) {
    const std::lock_guard lock(m_mutex);
    Logged& logged = m_logged[file];
    const std::string path = m_files[file].info.path.string();
    if (counts.outliers > 0 && !std::exchange(logged.stray, true))
        util::warn_of_file(path, kStray);
    warn_of_classes(file, counts);
}

void LoadReport::warn_of_classes(std::size_t file, const store::PointCounts& counts) {
    std::bitset<256>& logged = m_logged[file].classes;
    const std::bitset<256> met = unknown_codes(counts, m_classes) & ~logged;
    if (met.none())
        return;
    logged |= met;
    std::bitset<256> fresh = met;
    for (const std::bitset<256>& codes : m_unknown)
        fresh &= ~codes;
    if (fresh.any())
        m_unknown.push_back(fresh);
    for (const std::bitset<256>& codes : m_unknown)
        if ((met & codes).any())
            util::warn_of_file(m_files[file].info.path.string(),
                               describe_unknown(codes, m_classes));
}

store::PointCounts LoadReport::counts() const {
    const std::lock_guard lock(m_mutex);
    return m_counts;
}

namespace {

bool intact(const store::Square& square) {
    try {
        for (const store::PatchEntry& patch : square.patches())
            static_cast<void>(square.points(patch.key));
    } catch (const util::Error& e) {
        util::log_warn("{}; it is made again", e.what());
        return false;
    }
    return true;
}

}  // namespace

PreparedSquares::PreparedSquares(store::SquareFolder* folder, std::vector<std::string> names)
    : m_folder(folder), m_names(std::move(names)), m_verified(m_names.size()) {}

bool PreparedSquares::holds(std::size_t file) const {
    return m_folder != nullptr && m_folder->holds(m_names[file]);
}

std::shared_ptr<const store::Square> PreparedSquares::find(std::size_t file) {
    if (m_folder == nullptr)
        return nullptr;
    auto square = m_folder->find(m_names[file]);
    if (!square || !(m_verified[file] || intact(*square)))
        return nullptr;
    m_verified[file] = true;
    return square;
}

std::shared_ptr<const store::Square> PreparedSquares::keep(
    std::size_t file, std::shared_ptr<const store::Square> square) {
    if (m_folder == nullptr)
        return square;
    return m_folder->put(m_names[file], std::move(square));
}

WholeDecoder::WholeDecoder(std::size_t files, Load load, Keep keep)
    : m_load(std::move(load)), m_keep(std::move(keep)), m_failures(files) {}

std::shared_ptr<const store::Square> WholeDecoder::decode(std::size_t file) {
    const std::lock_guard lock(m_mutex);
    if (!m_failures[file].empty())
        throw util::Error(m_failures[file]);
    return m_keep(file, load(file));
}

LoadedSquare WholeDecoder::load(std::size_t file) {
    try {
        return m_load(file);
    } catch (const util::Error& e) {
        m_failures[file] = e.what();
        throw;
    }
}

namespace {

std::unique_ptr<store::SquareFolder> open_folder(const LidarWorldOptions& options) {
    if (options.cache_dir.empty())
        return nullptr;
    return std::make_unique<store::SquareFolder>(options.cache_dir / "squares",
                                                 options.cache_bytes);
}

std::unique_ptr<store::SquareFolder> open_indices(const LidarWorldOptions& options) {
    if (options.chunk_indices.empty())
        return nullptr;
    return std::make_unique<store::SquareFolder>(options.chunk_indices, store::kUnlimited_bytes);
}

std::vector<PartedFile> plan(std::span<const SquareSource> files, const PointMemory& memory,
                             const LoadContext& context, bool has_names) {
    const SquareRecipe recipe{context.frame, context.classes, context.settings};
    return plan_files(files, memory, has_names ? &recipe : nullptr);
}

std::vector<std::string> list_names(const std::vector<PartedFile>& files) {
    std::vector<std::string> out;
    out.reserve(files.size());
    for (const PartedFile& file : files)
        out.push_back(file.name);
    return out;
}

}  // namespace

SquareReader::SquareReader(const LidarWorldOptions& options, std::span<const SquareSource> files,
                           const PointMemory& memory, const LoadContext& context,
                           LoadReport& report)
    : m_times(context.times),
      m_report(report),
      m_folder(open_folder(options)),
      m_indices(open_indices(options)),
      m_files(plan(files, memory, context, m_folder != nullptr || m_indices != nullptr)),
      m_prepared(m_folder.get(), list_names(m_files)),
      m_parts(m_files, context, {m_folder.get(), m_indices.get(), options.reads_chunk_indices},
              memory.parts, thread::thread_count(options.threads),
              [&report](std::size_t file, const store::PointCounts& met, bool whole) {
                  whole ? report.add_whole(file, met) : report.add_part(file, met);
              }),
      m_decoder(
          m_files.size(),
          [this, context, threads = thread::thread_count(options.threads)](std::size_t file) {
              return load_square(*m_files[file].source, context, threads);
          },
          [this](std::size_t file, LoadedSquare loaded) { return keep(file, std::move(loaded)); }),
      m_squares(memory.squares),
      m_progress(m_files.size()) {}

Squares SquareReader::around(std::size_t file, const grid::PatchRect& wanted) {
    try {
        return read(file, wanted);
    } catch (const util::Error& e) {
        const std::lock_guard lock(m_mutex);
        m_progress[file].last_error = e.what();
        throw;
    }
}

std::pair<SquareState, std::string> SquareReader::find_state(std::size_t file) const {
    std::string error;
    bool in_memory = false;
    {
        const std::lock_guard lock(m_mutex);
        error = m_progress[file].last_error;
        in_memory = !m_progress[file].in_memory.expired();
    }
    if (in_memory || m_prepared.holds(file))
        return {SquareState::kPrepared, {}};
    if (!error.empty())
        return {SquareState::kFailed, std::move(error)};
    return {!m_files[file].kept_whole && m_parts.knows(file) ? SquareState::kPrepared
                                                             : SquareState::kFetched,
            {}};
}

Squares SquareReader::read(std::size_t file, const grid::PatchRect& wanted) {
    if (!m_files[file].kept_whole)
        return m_parts.around(file, wanted);
    if (auto square = m_squares.find(file))
        return {std::move(square)};
    if (m_prepared.holds(file) || !m_parts.are_enough(file, wanted))
        return {whole(file)};
    return m_parts.around(file, wanted);
}

std::shared_ptr<const store::Square> SquareReader::whole(std::size_t file) {
    auto found = m_squares.get(
        file, [&] { return find_or_decode(file); },
        [](const auto& s) { return s->memory_bytes(); });
    const std::lock_guard lock(m_mutex);
    m_progress[file].in_memory = found;
    return found;
}

std::shared_ptr<const store::Square> SquareReader::find_or_decode(std::size_t file) {
    auto square = m_prepared.find(file);
    if (!square)
        return m_decoder.decode(file);
    m_report.add_whole(file, square->counts());
    return square;
}

std::shared_ptr<const store::Square> SquareReader::keep(std::size_t file, LoadedSquare loaded) {
    m_report.add_whole(file, loaded.square->counts());
    if (!m_folder) {
        m_parts.learn(file, std::move(loaded.index));
        return loaded.square;
    }
    const util::StageTimes::Scope timed(m_times, "square store");
    m_parts.learn(file, std::move(loaded.index));
    return m_prepared.keep(file, std::move(loaded.square));
}

}  // namespace terravox::voxelize
