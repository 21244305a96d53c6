#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "common/util/log.hpp"

namespace terravox::voxel {

/// Logs which data of a world could not be read: at most the first 20 lines, and the total number.
inline void log_damage(const std::vector<std::string>& damage) {
    constexpr std::size_t kMaxLines = 20;
    for (std::size_t i = 0; i < std::min(damage.size(), kMaxLines); ++i)
        util::log_error("{}", damage[i]);
    util::log_error("the world is damaged in {} {}; the rest is there", damage.size(),
                    damage.size() == 1 ? "place" : "places");
}

}  // namespace terravox::voxel
