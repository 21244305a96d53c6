#pragma once

#include <algorithm>
#include <random>

#include "tests/voxelserver/voxelize/world/cloud.hpp"

namespace terravox::test {

/// A world that reports which steps have run.
class TimedWorld {
public:
    explicit TimedWorld(const voxelize::LidarWorldOptions& options)
        : m_world(voxelize::open_lidar_world(options, m_times)) {}
    [[nodiscard]] voxelize::LidarWorld& operator*() { return *m_world; }
    [[nodiscard]] voxelize::LidarWorld* operator->() { return m_world.get(); }

    /// How often a step ran; "point load" runs once for each stretch of a file that is decoded.
    [[nodiscard]] std::uint64_t count(const std::string& stage) const {
        for (const auto& s : m_times.stages())
            if (s.name == stage)
                return s.count;
        return 0;
    }
    /// What all boxes of the finest level hold. @param shuffle 0 = in order
    Checksums boxes(unsigned shuffle = 0) {
        auto keys = all_keys(m_world->info(), 0);
        if (shuffle != 0)
            std::shuffle(keys.begin(), keys.end(), std::mt19937(shuffle));
        return checksums(*m_world, keys);
    }

private:
    util::StageTimes m_times;
    std::unique_ptr<voxelize::LidarWorld> m_world;
};

inline int solid_boxes(const Checksums& boxes) {
    return static_cast<int>(
        std::count_if(boxes.begin(), boxes.end(), [](const auto& e) { return e.second != 0; }));
}

}  // namespace terravox::test
