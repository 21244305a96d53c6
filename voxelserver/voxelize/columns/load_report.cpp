#include "voxelserver/voxelize/columns/load_report.hpp"
#include "common/util/log.hpp"

#include <string>
#include <utility>

namespace terravox::voxelize {
namespace {

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

LoadReport::LoadReport(std::span<const SquareSource> files, const ClassTable& classes)
    : m_files(files), m_classes(classes), m_logged(files.size()) {}

void LoadReport::add_whole(std::size_t file, const store::PointCounts& counts) {
    std::call_once(m_logged[file].whole, [&] {
        const std::string path = m_files[file].info.path.string();
        if (counts.outliers > 0)
            util::log_warn("{}: {} stray points, outside the bounds of all others; left out", path,
                           counts.outliers);
        const std::string unknown = unknown_classes(counts, m_classes);
        if (!unknown.empty())
            util::log_warn("{}: classes that the table '{}' does not name: {}; shown as `unknown`",
                           path, m_classes.id, unknown);
        const std::lock_guard lock(m_mutex);
        m_counts.add(counts);
    });
}

void LoadReport::add_part(std::size_t file, const store::PointCounts& counts) {
    const std::lock_guard lock(m_mutex);
    Logged& logged = m_logged[file];
    const std::string path = m_files[file].info.path.string();
    if (counts.outliers > 0 && !std::exchange(logged.stray, true))
        util::log_warn("{}: stray points, outside the bounds of all others; left out", path);
    for (std::size_t c = 0; c < counts.by_class.size(); ++c)
        if (counts.by_class[c] > 0 && !m_classes.meaning[c].known && !logged.classes[c]) {
            logged.classes[c] = true;
            util::log_warn("{}: class {}, which the table '{}' does not name; shown as `unknown`",
                           path, c, m_classes.id);
        }
}

store::PointCounts LoadReport::counts() const {
    const std::lock_guard lock(m_mutex);
    return m_counts;
}

}  // namespace terravox::voxelize
