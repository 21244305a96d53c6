#include "voxelserver/out/export/core/job.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/changed_error.hpp"

namespace terravox::exports {

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
    Columns made(block_of(part.boxes()), edge,
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

}  // namespace terravox::exports
