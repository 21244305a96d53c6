#include "raytracer/apps/preview/frame_times.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace terravox::preview {
namespace {

constexpr std::size_t kMax =
    1'000'000;  // hours of frames; what comes later is like what came before

nlohmann::json quantiles(std::vector<float> values) {
    if (values.empty())
        return {{"count", 0}};
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
        return static_cast<double>(
            values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))]);
    };
    return {{"count", values.size()},
            {"median_s", at(0.5)},
            {"p95_s", at(0.95)},
            {"p99_s", at(0.99)},
            {"most_s", at(1)}};
}

}  // namespace

void FrameTimes::note(std::vector<float>& to, double seconds) {
    if (&to == &m_frames)
        m_recent_s = m_recent_s == 0 ? seconds : 0.9 * m_recent_s + 0.1 * seconds;
    if (to.size() < kMax)
        to.push_back(static_cast<float>(seconds));
}

nlohmann::json FrameTimes::report() const {
    return {{"frames", quantiles(m_frames)},
            {"first_pictures", quantiles(m_firsts)},
            {"stops", quantiles(m_stops)}};
}

}  // namespace terravox::preview
