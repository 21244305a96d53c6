#include "common/util/stage_times.hpp"

#include <algorithm>

namespace terravox::util {

void StageTimes::add(const std::string& name, double seconds) {
    const std::lock_guard lock(m_mutex);
    auto at = std::find_if(m_stages.begin(), m_stages.end(),
                           [&](const Stage& s) { return s.name == name; });
    if (at == m_stages.end())
        at = m_stages.insert(at, Stage{name, 0, 0});
    at->seconds += seconds;
    ++at->count;
}

std::vector<StageTimes::Stage> StageTimes::stages() const {
    const std::lock_guard lock(m_mutex);
    return m_stages;
}

}  // namespace terravox::util
