#include "voxelserver/make/voxelize/columns/load_report.hpp"
#include "common/util/log.hpp"

#include <bitset>
#include <string>
#include <utility>

namespace terravox::voxelize {
namespace {

std::bitset<256> unknown_codes(const store::PointCounts& counts, const ClassTable& classes) {
    std::bitset<256> out;
    for (std::size_t c = 0; c < counts.by_class.size(); ++c)
        out[c] = counts.by_class[c] > 0 && !classes.meaning[c].known;
    return out;
}

std::string list_of(const std::bitset<256>& codes, const store::PointCounts& counts) {
    constexpr int kNamed = 8;
    std::string out;
    int found = 0;
    for (std::size_t c = 0; c < codes.size(); ++c) {
        if (!codes[c])
            continue;
        if (++found <= kNamed)
            out += (out.empty() ? "" : ", ") + std::to_string(c) + " (" +
                   std::to_string(counts.by_class[c]) + " points)";
    }
    return found > kNamed ? out + " and " + std::to_string(found - kNamed) + " more" : out;
}

/// What becomes of points of these classes, and what to do about it.
std::string shown_as(const std::bitset<256>& codes) {
    const std::string tables = tables_that_name(codes);
    return tables.empty() ? "shown as `unknown`"
                          : "shown as `unknown`; tables that name them (--classes): " + tables;
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
        if (const std::bitset<256> unknown = unknown_codes(counts, m_classes); unknown.any())
            util::log_warn("{}: classes that the table '{}' does not name: {}; {}", path,
                           m_classes.id, list_of(unknown, counts), shown_as(unknown));
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
    const std::bitset<256> unknown = unknown_codes(counts, m_classes) & ~logged.classes;
    logged.classes |= unknown;
    for (std::size_t c = 0; c < unknown.size(); ++c)
        if (unknown[c])
            util::log_warn("{}: class {}, which the table '{}' does not name; {}", path, c,
                           m_classes.id, shown_as(std::bitset<256>().set(c)));
}

store::PointCounts LoadReport::counts() const {
    const std::lock_guard lock(m_mutex);
    return m_counts;
}

}  // namespace terravox::voxelize
