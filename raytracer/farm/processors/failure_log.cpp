#include "raytracer/farm/processors/failure_log.hpp"

#include <algorithm>
#include <set>

namespace terravox::processors {
namespace {

bool share_rows(const tiles::RenderTile& a, const tiles::RenderTile& b) noexcept {
    return a.index == b.index && a.y0 < b.y1 && b.y0 < a.y1;
}

}  // namespace

std::size_t FailureLog::add(const tiles::RenderTile& band, const std::string& identity) {
    const auto is_known = [&](const Failure& f) {
        return f.identity == identity && f.band == band;
    };
    if (std::none_of(m_failures.begin(), m_failures.end(), is_known))
        m_failures.push_back({band, identity});
    std::set<std::string> different;
    for (const Failure& f : m_failures)
        if (share_rows(f.band, band))
            different.insert(f.identity);
    return different.size();
}

}  // namespace terravox::processors
