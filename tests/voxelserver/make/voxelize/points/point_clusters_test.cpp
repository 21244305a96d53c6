// Which points of a file belong together, however they are ordered.
#include <algorithm>
#include <random>

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "voxelserver/data/lidar/las_source.hpp"
#include "voxelserver/make/voxelize/points/extent.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

const KeepsPoint kAll = [](const pointcloud::Point&) { return true; };

Cloud shuffled(const Cloud& cloud, unsigned seed) {
    auto points = cloud.points();
    std::mt19937 random(seed);
    for (std::size_t i = points.size(); i > 1; --i)
        std::swap(points[i - 1], points[random() % i]);
    Cloud out;
    for (const auto& p : points)
        out.add(p.east, p.north, p.height, p.source_class);
    return out;
}

PointCluster cluster(std::uint64_t count, double wide) {
    return {count, {0, 0, 0}, {wide, wide, 0}};
}

}  // namespace

TEST_CASE(
    "clusters are the same in every order of the points, packed or plain, on any number of threads",
    "[voxelserver][voxelize][clusters]") {
    const unsigned seed = GENERATE(range(1u, 4u));
    std::mt19937 random(seed);
    const TemporaryFolder folder;
    Cloud cloud;
    std::size_t points = 0;
    const int places = 1 + static_cast<int>(random() % 5);
    for (int i = 0; i < places; ++i) {
        const auto count = 1 + random() % 60'000;
        points += count;
        const auto metres = [&] { return static_cast<double>(random() % 300'000) / 1000; };
        for (std::size_t k = 0; k < count; ++k) {
            const double east = 3000.0 * i + metres();
            const double north = metres();
            cloud.add(east, north, 7, 2);
        }
    }
    cloud.write(folder.path() / "a.laz");
    shuffled(cloud, seed).write(folder.path() / "b.laz");
    shuffled(cloud, seed + 1).write(folder.path() / "c.las");
    const auto found = find_clusters(lidar::LasSource(folder.path() / "a.laz"), kAll, 1, 1);
    INFO("seed " << seed);
    REQUIRE(found.size() == static_cast<std::size_t>(places));
    std::uint64_t sum = 0;
    for (const PointCluster& c : found)
        sum += c.count;
    CHECK(sum == points);
    CHECK(std::is_sorted(
        found.begin(), found.end(),
        [](const PointCluster& a, const PointCluster& b) { return a.count > b.count; }));
    for (const char* name : {"b.laz", "c.las"})
        CHECK((find_clusters(lidar::LasSource(folder.path() / name), kAll, 1, 2) == found));
}

TEST_CASE("points less than a kilometre apart are connected, and dropped ones do not count",
          "[voxelserver][voxelize][clusters]") {
    struct Case {
        const char* name;
        double step;
        double unit_m;
        std::size_t clusters;
    };
    const auto c = GENERATE(values<Case>({{"a chain", 900, 1, 1},
                                          {"too far", 1400, 1, 10},
                                          {"a chain in feet", 2900, 0.3048, 1},
                                          {"too far in feet", 4600, 0.3048, 10}}));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder folder;
        Cloud cloud;
        for (int i = 0; i < 10; ++i) {
            cloud.add(c.step * i, 0, 1, 2);
            cloud.add(c.step * (i + 0.5), 50'000, 1, 7);
        }
        cloud.write(folder.path() / "a.laz");
        const KeepsPoint no_noise = [](const pointcloud::Point& p) {
            return p.classification != 7;
        };
        const auto found =
            find_clusters(lidar::LasSource(folder.path() / "a.laz"), no_noise, c.unit_m, 2);
        CHECK(found.size() == c.clusters);
    }
}

TEST_CASE("clusters of outliers are few points, or many in one place, and always a small share",
          "[voxelserver][voxelize][clusters]") {
    struct Case {
        const char* name;
        std::vector<PointCluster> clusters;
        std::size_t left;
    };
    const auto c = GENERATE(values<Case>({
        {"none", {}, 0},
        {"one point alone", {cluster(1, 0)}, 1},
        {"one point and a thousand", {cluster(1000, 300), cluster(1, 0)}, 1},
        {"one point and fifty", {cluster(50, 300), cluster(1, 0)}, 2},
        {"99 points and many", {cluster(1'000'000, 300), cluster(99, 200)}, 1},
        {"100 points, an islet", {cluster(1'000'000, 300), cluster(100, 12)}, 2},
        {"many points in one place", {cluster(1'000'000, 300), cluster(9000, 0.5)}, 1},
        {"more than a hundredth in one place", {cluster(1'000'000, 300), cluster(11'000, 0.5)}, 2},
        {"equals", {cluster(70, 1), cluster(70, 1)}, 2},
    }));
    DYNAMIC_SECTION(c.name) {
        auto clusters = c.clusters;
        drop_strays(clusters, 1);
        CHECK(clusters.size() == c.left);
        if (c.left > 0)
            CHECK((clusters.front() == c.clusters.front()));
    }
}
