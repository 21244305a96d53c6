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

}  // namespace terravox::farm
