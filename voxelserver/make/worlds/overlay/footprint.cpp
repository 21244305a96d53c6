#include "voxelserver/make/worlds/overlay/footprint.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace terravox::overlay {
namespace {

/// Calls visit(x) for each side of a ring that crosses the line at z.
template <class Visit>
void each_crossing(const Footprint::Ring& ring, double z, const Visit& visit) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Footprint::Point& a = ring[i];
        const Footprint::Point& b = ring[(i + 1) % ring.size()];
        // Half-open, so that a corner on the line counts once.
        if ((a[1] <= z) == (b[1] <= z))
            continue;
        visit(a[0] + (b[0] - a[0]) * ((z - a[1]) / (b[1] - a[1])));
    }
}

}  // namespace

Footprint::Footprint(std::vector<Ring> rings) : m_rings(std::move(rings)) {
    if (m_rings.empty() || m_rings.front().size() < 3)
        throw std::invalid_argument("a border of fewer than three corners");
    m_min = m_max = m_rings.front().front();
    for (const Ring& ring : m_rings)
        for (const Point& p : ring)
            for (std::size_t a = 0; a < 2; ++a) {
                m_min[a] = std::min(m_min[a], p[a]);
                m_max[a] = std::max(m_max[a], p[a]);
            }
    // The widest stretch inside, on a line through its middle.
    const double z = (m_min[1] + m_max[1]) / 2;
    const std::vector<double> at = crossings(z);
    double widest = 0;
    for (std::size_t i = 0; i + 1 < at.size(); i += 2)
        if (at[i + 1] - at[i] > widest) {
            widest = at[i + 1] - at[i];
            m_middle = {(at[i] + at[i + 1]) / 2, z};
        }
    if (!(widest > 0))
        throw std::invalid_argument("nothing lies inside of it");
}

std::vector<double> Footprint::crossings(double z) const {
    std::vector<double> out;
    for (const Ring& ring : m_rings)
        each_crossing(ring, z, [&](double x) { out.push_back(x); });
    std::sort(out.begin(), out.end());
    return out;
}

bool Footprint::is_inside(const std::vector<double>& crossings, double x) noexcept {
    // Those at x are passed: a point on a border in the west is inside.
    const auto passed = std::upper_bound(crossings.begin(), crossings.end(), x);
    return (passed - crossings.begin()) % 2 == 1;
}

}  // namespace terravox::overlay
