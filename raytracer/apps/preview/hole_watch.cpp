#include "raytracer/apps/preview/hole_watch.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace terravox::preview {

bool HoleWatch::look(const std::set<voxel::BoxKey>& holes,
                     std::optional<Clock::time_point> idle_since, Clock::time_point now) {
    if (m_requested) {
        if (!m_loaded)
            return false;
        const blocks::BlockPin pin = m_blocks.find(*std::exchange(m_requested, std::nullopt));
        const bool there = pin && !pin->hole;
        m_since = now;
        m_wait = there ? kFirst : std::min(m_wait * 2, kMax);
        return there;
    }
    if (!idle_since)
        return false;
    if (holes.empty())
        m_wait = kFirst;
    if (holes.empty() || now - std::max(m_since, *idle_since) < m_wait)
        return false;
    // A different hole each time: some may be damaged permanently.
    m_requested = *std::next(holes.begin(), static_cast<std::ptrdiff_t>(m_turn++ % holes.size()));
    m_loaded = false;
    m_blocks.forget_holes();
    m_blocks.wait_for(*m_requested, *this, 0);
    return false;
}

}  // namespace terravox::preview
