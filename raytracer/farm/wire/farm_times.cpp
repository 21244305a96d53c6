#include <algorithm>
#include <cstdlib>
#include <string_view>

#include "raytracer/farm/wire/tile_frames.hpp"

namespace terravox::farm {

const FarmTimes& farm_times() {
    static const FarmTimes times = [] {
        FarmTimes out;
        const char* test = std::getenv("TERRAVOX_FARM_TEST");
        if (test == nullptr || std::string_view(test) != "1")
            return out;
        using std::chrono::milliseconds;
        out.ping = milliseconds(200);
        out.silence = milliseconds(3000);
        out.heartbeat = milliseconds(100);
        out.min_deadline = milliseconds(2000);
        out.redial = milliseconds(200);
        out.max_redial = milliseconds(1000);
        return out;
    }();
    return times;
}

std::chrono::milliseconds RedialPause::next() {
    const std::chrono::milliseconds whole = m_next;
    m_next = std::min(whole * 2, farm_times().max_redial);
    const auto most = static_cast<std::uint32_t>(whole.count() / 4);
    return whole - std::chrono::milliseconds(m_random() % (most + 1));
}

}  // namespace terravox::farm
