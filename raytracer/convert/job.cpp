#include "raytracer/convert/job.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "common/util/error.hpp"

namespace terravox::convert {

std::shared_ptr<const voxel::Box> Job::box(std::int32_t bx, std::int32_t by, std::int32_t bz) {
    const voxel::BoxKey key{part.level, bx, by, bz};
    try {
        return m_world.box(key);
    } catch (const Error& e) {
        hole(key, e.what());
        return nullptr;
    }
}

voxel::ColumnExtent Job::column(std::int32_t bx, std::int32_t bz) {
    const voxel::BoxRange range = part.boxes();
    voxel::ColumnExtent out{range.min.by, range.max.by};
    try {
        const voxel::ColumnExtent told = m_world.column(part.level, bx, bz);
        out = {std::max(out.by_begin, told.by_begin), std::min(out.by_end, told.by_end)};
    } catch (const Error& e) {
        spdlog::debug("{}", e.what());  // its boxes say it again, and count
    }
    return out;
}

void Job::hole(const voxel::BoxKey& key, const char* what) {
    const std::lock_guard lock(m_mutex);
    if (std::find(m_holes.begin(), m_holes.end(), key) != m_holes.end()) return;
    m_holes.push_back(key);
    spdlog::error("{}", what);
}

void Job::wrote(const std::filesystem::path& file) {
    const std::lock_guard lock(m_mutex);
    m_files.push_back(file);
}

std::vector<std::filesystem::path> Job::files() const {
    const std::lock_guard lock(m_mutex);
    auto out = m_files;
    std::sort(out.begin(), out.end());
    return out;
}

std::vector<voxel::BoxKey> Job::holes() const {
    const std::lock_guard lock(m_mutex);
    return m_holes;
}

}  // namespace terravox::convert
