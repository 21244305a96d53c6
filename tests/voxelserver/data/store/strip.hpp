#pragma once

#include <algorithm>
#include <random>

#include "common/geo/crs.hpp"
#include "tests/voxelserver/data/store/squares.hpp"
#include "tests/voxelserver/data/store/timed_world.hpp"

namespace terravox::test {

inline constexpr std::size_t kStripPoints = 400'000;  ///< 8 chunks of a LAZ file

/// A file of many chunks: a strip of hills, 1300 x 110 m. @param sorted by easting, so that a part
/// of it lies in few chunks
inline void write_strip(const std::filesystem::path& file, bool sorted) {
    std::mt19937 random(31);
    const auto unit = [&] { return static_cast<double>(random() % 1'000'000) / 1'000'000; };
    std::vector<double> east(kStripPoints);
    for (double& e : east)
        e = 1300 * unit();
    if (sorted)
        std::sort(east.begin(), east.end());
    Cloud cloud;
    for (const double e : east) {
        const double n = 110 * unit();
        const bool lake = std::hypot(e - 600, n - 50) < 30;
        const bool tree = !lake && std::sin(e / 7) * std::sin(n / 6) > 0.8 && unit() < 0.5;
        const double hills = 155 + 6 * std::sin(e / 41) + 4 * std::cos(n / 19);
        cloud.add(e, n, lake ? 148 : hills + (tree ? 3 + 5 * unit() : 0), lake ? 9 : tree ? 5 : 2);
    }
    cloud.write(file);
}

/// The strip, written once, and what its boxes hold when all of it is decoded at once.
struct Strip {
    TemporaryFolder folder;
    std::filesystem::path sorted = folder.path() / "sorted.laz";
    std::filesystem::path mixed = folder.path() / "mixed.laz";
    std::uint64_t stretches = 0;  ///< in which the whole file is decoded
    Checksums boxes;

    static const Strip& get() {
        static const Strip made;
        return made;
    }

private:
    Strip() {
        write_strip(sorted, true);
        write_strip(mixed, false);
        TimedWorld world(OpenWorld::with(sorted));
        boxes = world.boxes();
        stretches = world.count("point load");
    }
};

}  // namespace terravox::test
