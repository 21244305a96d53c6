#include "raytracer/farm/coordinator/latency_meter.hpp"

#include <algorithm>

namespace terravox::farm {

void LatencyMeter::ping_sent(std::uint64_t stamp) {
    const std::lock_guard lock(m_mutex);
    if (m_outstanding.size() == kMaxOutstanding)
        m_outstanding.pop_front();
    m_outstanding.push_back(stamp);
}

bool LatencyMeter::pong_received(std::uint64_t stamp, std::uint64_t now_ns) {
    const std::lock_guard lock(m_mutex);
    const auto found = std::find(m_outstanding.begin(), m_outstanding.end(), stamp);
    if (found == m_outstanding.end())
        return false;
    m_outstanding.erase(m_outstanding.begin(), found + 1);
    const double passed_s = static_cast<double>(now_ns - stamp) / 1e9;
    const double before_s = m_average_s;
    m_average_s = before_s == 0 ? passed_s : 0.8 * before_s + 0.2 * passed_s;
    return true;
}

}  // namespace terravox::farm
