#pragma once

#include <algorithm>
#include <random>

#include "tests/voxelserver/make/voxelize/world/cloud.hpp"

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

/// Hills with a road, trees and noise, 150 x 130 m.
inline const Cloud& hills() {
    static const Cloud made = [] {
        Cloud cloud;
        std::mt19937 random(12);
        const auto unit = [&] { return static_cast<double>(random() % 100'000) / 100'000; };
        for (int i = 0; i < 30'000; ++i) {
            const double e = 0.05 + unit() * 149.9;
            const double n = 0.05 + unit() * 129.9;
            const double ground = 200 + 6 * std::sin(e / 31) + 4 * std::cos(n / 17);
            cloud.add(e, n, ground, n > 60 && n < 66 ? 11 : 2);
            if (i % 3 == 0 && std::sin(e / 6) * std::sin(n / 6) > 0.6)
                cloud.add(e, n, ground + 2 + unit() * 9, 5);
            if (i % 50 == 0)
                cloud.add(e, n, ground + 40, 7);
        }
        return cloud;
    }();
    return made;
}

}  // namespace terravox::test
