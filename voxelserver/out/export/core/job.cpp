#include "voxelserver/out/export/core/job.hpp"

#include <unistd.h>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/world.hpp"

namespace terravox::exports {
namespace {

constexpr double kTerminalEvery_s = 0.1;
constexpr double kPlainEvery_s = 5;

double seconds(std::chrono::steady_clock::duration d) {
    return std::chrono::duration<double>(d).count();
}

}  // namespace

Meter::Meter(std::string what, std::uint64_t total, bool quiet,
             std::function<void(std::uint64_t, std::uint64_t)> told)
    : m_what(std::move(what)),
      m_total(total),
      m_quiet(quiet),
      m_terminal(::isatty(STDERR_FILENO) == 1),
      m_told(std::move(told)),
      m_start(std::chrono::steady_clock::now()),
      m_last(m_start) {}

void Meter::add(std::uint64_t steps) {
    const std::lock_guard lock(m_mutex);
    advance(m_done + steps);
}

void Meter::reach(std::uint64_t done, std::uint64_t all) {
    const std::lock_guard lock(m_mutex);
    if (const std::uint64_t steps = all == 0 ? 0 : done * m_total / all; steps > m_done)
        advance(steps);
}

void Meter::advance(std::uint64_t done) {
    m_done = done;
    if (m_told)
        m_told(m_done, m_total);
    const auto now = std::chrono::steady_clock::now();
    if (m_finished || seconds(now - m_last) < (m_terminal ? kTerminalEvery_s : kPlainEvery_s))
        return;
    m_last = now;
    show(false);
}

void Meter::finish() {
    const std::lock_guard lock(m_mutex);
    if (m_shown && !m_finished)
        show(true);
    m_finished = true;
}

void Meter::show(bool last) {
    if (m_quiet)
        return;
    m_shown = true;
    const double share =
        m_total == 0 ? 1
                     : std::min(1.0, static_cast<double>(m_done) / static_cast<double>(m_total));
    const double elapsed = seconds(std::chrono::steady_clock::now() - m_start);
    const double left = share > 0 ? elapsed / share - elapsed : 0;
    if (m_terminal) {
        constexpr int kWidth = 32;
        std::string bar(kWidth, '.');
        std::fill_n(bar.begin(), static_cast<std::ptrdiff_t>(share * kWidth), '#');
        std::fprintf(stderr, "\r%s [%s] %3.0f %%  %.0f s left \x1b[K%s", m_what.c_str(),
                     bar.c_str(), share * 100, left, last ? "\n" : "");
    } else {
        std::fprintf(stderr, "%s %3.0f %%  %.0f s left\n", m_what.c_str(), share * 100, left);
    }
    std::fflush(stderr);
}

voxel::BoxOutcome Job::outcome(std::int32_t bx, std::int32_t by, std::int32_t bz) {
    const voxel::BoxKey key{part.level, bx, by, bz};
    voxel::BoxOutcome got;
    if (stop.stop_requested())
        throw util::Error("convert to " + out.string() + ": interrupted");
    try {
        got.box = m_world.box(key);
    } catch (const voxel::ChangedError&) {
        throw;
    } catch (const util::Error& e) {
        hole(key, e.what());
        got.failure = std::current_exception();
    }
    return got;
}

voxel::ColumnExtent Job::column(std::int32_t bx, std::int32_t bz) {
    const voxel::BoxRange range = part.boxes();
    voxel::ColumnExtent extent{range.min.by, range.max.by};
    try {
        const voxel::ColumnExtent reported = m_world.column(part.level, bx, bz);
        extent = {std::max(extent.by_begin, reported.by_begin),
                  std::min(extent.by_end, reported.by_end)};
    } catch (const voxel::ChangedError&) {
        throw;
    } catch (const util::Error& e) {
        util::log_debug("{}", e.what());  // its boxes report it again, and count
    }
    return extent;
}

bool Job::may_hold(const ColumnBlock& columns) {
    voxel::BoxRange range = part.boxes();
    range.min.bx = std::max(range.min.bx, columns.min_bx);
    range.min.bz = std::max(range.min.bz, columns.min_bz);
    range.max.bx = std::min(range.max.bx, columns.max_bx);
    range.max.bz = std::min(range.max.bz, columns.max_bz);
    if (range.min.bx >= range.max.bx || range.min.bz >= range.max.bz)
        return false;
    try {
        return m_world.may_hold(range);
    } catch (const voxel::ChangedError&) {
        throw;
    } catch (const util::Error& e) {
        util::log_debug("{}", e.what());  // its boxes report it again, and count
        return true;
    }
}

Columns Job::columns(std::size_t edge) {
    Columns made(to_block(part.boxes()), edge,
                 [this](const ColumnBlock& block) { return may_hold(block); });
    meter.add(made.left_out());
    return made;
}

std::vector<std::string> Job::damage_lines() const {
    std::vector<std::string> lines = left_out;
    const auto met = m_world.damage();
    lines.insert(lines.end(), met.begin(), met.end());
    return lines;
}

void Job::hole(const voxel::BoxKey& key, const char* what) {
    const std::lock_guard lock(m_mutex);
    constexpr std::size_t kMaxReported = 20;
    if (m_holes.insert(key).second)
        util::log_message(
            m_holes.size() <= kMaxReported ? util::LogLevel::kError : util::LogLevel::kDebug, "{}",
            what);
}

void Job::wrote(const std::filesystem::path& file) {
    const std::lock_guard lock(m_mutex);
    m_files.push_back(file);
}

std::vector<std::filesystem::path> Job::files() const {
    const std::lock_guard lock(m_mutex);
    auto sorted = m_files;
    std::sort(sorted.begin(), sorted.end());
    return sorted;
}

std::vector<voxel::BoxKey> Job::holes() const {
    const std::lock_guard lock(m_mutex);
    return {m_holes.begin(), m_holes.end()};
}

namespace {

std::int32_t voxel_at(double value, double per_voxel, bool upper) {
    constexpr double kFarthest = 1 << 30;
    const double at = value / per_voxel;
    return static_cast<std::int32_t>(
        std::clamp(upper ? std::ceil(at) : std::floor(at), -kFarthest, kFarthest));
}

}  // namespace

Part make_part(const voxel::WorldInfo& world, const Selection& s) {
    const auto refuse = [](const std::string& what) -> void {
        throw util::UsageError("choose the part: " + what);
    };
    const auto text = [](const std::vector<double>& numbers) {
        std::string out;
        for (const double n : numbers)
            out += (out.empty() ? "" : ",") + std::to_string(n);
        return out;
    };
    if (s.level < 0 || s.level >= world.levels)
        refuse("level " + std::to_string(s.level) + "; allowed: 0 to " +
               std::to_string(world.levels - 1));
    voxel::VoxelBounds b = s.area.empty() ? world.framed_bounds() : world.bounds;
    if (!s.area.empty()) {
        if (s.area[0] >= s.area[2] || s.area[1] >= s.area[3])
            refuse("--area " + text(s.area) +
                   " is empty or upside down; allowed: west,south,east,north, or x0,z0,x1,z1 in a "
                   "world without a CRS");
        const bool placed = !world.crs.empty();
        const double unit = placed ? world.crs_units_per_voxel : 1;
        b.min[0] = std::max(b.min[0], voxel_at(s.area[0], unit, false));
        b.max[0] = std::min(b.max[0], voxel_at(s.area[2], unit, true));
        // Northings grow to the north, z to the south.
        b.min[2] = std::max(b.min[2], voxel_at(placed ? -s.area[3] : s.area[1], unit, false));
        b.max[2] = std::min(b.max[2], voxel_at(placed ? -s.area[1] : s.area[3], unit, true));
    }
    if (!s.heights.empty()) {
        if (s.heights[0] >= s.heights[1])
            refuse("--heights " + text(s.heights) +
                   " is empty or upside down; allowed: lowest,highest in metres");
        b.min[1] = std::max(b.min[1], voxel_at(s.heights[0], world.voxel_m, false));
        b.max[1] = std::min(b.max[1], voxel_at(s.heights[1], world.voxel_m, true));
    }
    if (b.empty()) {
        const auto& all = world.bounds;
        const double unit = world.crs.empty() ? 1 : world.crs_units_per_voxel;
        const double south = world.crs.empty() ? all.min[2] : -all.max[2] * unit;
        const double north = world.crs.empty() ? all.max[2] : -all.min[2] * unit;
        refuse("nothing of the world lies in it; allowed: --area within " +
               text({all.min[0] * unit, south, all.max[0] * unit, north}) + ", --heights within " +
               text({all.min[1] * world.voxel_m, all.max[1] * world.voxel_m}));
    }
    Part part{s.level, b};
    for (std::size_t a = 0; a < 3; ++a) {
        part.bounds.min[a] = b.min[a] >> s.level;
        part.bounds.max[a] = (b.max[a] - 1) >> s.level;
        ++part.bounds.max[a];
    }
    // All boxes of each column of boxes are requested.
    constexpr std::int32_t kMaxHigh = 4096;
    const voxel::BoxRange boxes = part.boxes();
    if (const std::int32_t high = boxes.max.by - boxes.min.by; high > kMaxHigh)
        refuse(std::to_string(high) + " boxes of " + std::to_string(voxel::kBoxSizeY) +
               " voxels high; allowed: up to " + std::to_string(kMaxHigh) +
               ", by --heights or a coarser --level");
    return part;
}

}  // namespace terravox::exports
