#include "voxelserver/make/voxelize/points/point_clusters.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>
#include <string>
#include <tuple>
#include <unordered_map>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"

namespace terravox::voxelize {
namespace {

constexpr double kCell_m = 256;
constexpr int kReach = 4;                     // cells: clusters are a kilometre apart or more
constexpr std::size_t kMaxCells = 1'000'000;  // 65,000 square kilometres; some tens of MB
constexpr std::uint64_t kPointsPerScan = 200'000;

using Cells = std::unordered_map<std::uint64_t, PointCluster>;

std::uint64_t key_of(std::int64_t i, std::int64_t k) noexcept {
    return static_cast<std::uint64_t>(static_cast<std::uint32_t>(i)) << 32 |
           static_cast<std::uint32_t>(k);
}

// Sums, minima and maxima: the order of adding does not matter.
void add(PointCluster& to, const PointCluster& from) noexcept {
    if (to.count == 0) {
        to = from;
        return;
    }
    to.count += from.count;
    for (std::size_t a = 0; a < 3; ++a) {
        to.min[a] = std::min(to.min[a], from.min[a]);
        to.max[a] = std::max(to.max[a], from.max[a]);
    }
}

void add_all(Cells& to, const Cells& from, const pointcloud::PointSource& source) {
    for (const auto& [key, cell] : from)
        add(to[key], cell);
    if (to.size() > kMaxCells)
        throw util::Error("place the point cloud " + source.info().path.string() +
                          ": its points are strewn over more than " + std::to_string(kMaxCells) +
                          " squares of 256 m");
}

// Neighbours in a file are neighbours in space: the cell is mostly that of the previous point.
Cells cells_of(const pointcloud::PointSource& source, const pointcloud::PointRange& range,
               const KeepsPoint& keeps, double cell_units) {
    Cells out;
    std::uint64_t last_key = 0;
    PointCluster* last = nullptr;
    source.read({&range, 1}, [&](std::span<const pointcloud::Point> batch) {
        for (const pointcloud::Point& p : batch) {
            if (!keeps(p))
                continue;
            const std::array<double, 3> at{p.x, p.y, p.z};
            constexpr double kFarthest = 1.0e9;  // cells; what lies beyond shares one
            const auto index = [&](double v) {
                return static_cast<std::int64_t>(
                    std::clamp(std::floor(v / cell_units), -kFarthest, kFarthest));
            };
            const std::uint64_t key = key_of(index(at[0]), index(at[1]));
            if (last == nullptr || key != last_key) {
                last = &out[key];
                last_key = key;
            }
            add(*last, {1, at, at});
        }
    });
    return out;
}

// Removes the cells that can be reached from one of them, step by step, from those left.
PointCluster take_cluster(Cells& left) {
    PointCluster out;
    std::vector<std::uint64_t> next;
    const auto take = [&](Cells::iterator cell) {
        add(out, cell->second);
        next.push_back(cell->first);
        left.erase(cell);
    };
    take(left.begin());
    while (!next.empty()) {
        const auto i = static_cast<std::int32_t>(next.back() >> 32);
        const auto k = static_cast<std::int32_t>(next.back() & 0xFFFFFFFF);
        next.pop_back();
        for (int dk = -kReach; dk <= kReach; ++dk)
            for (int di = -kReach; di <= kReach; ++di)
                if (const auto found =
                        left.find(key_of(std::int64_t{i} + di, std::int64_t{k} + dk));
                    found != left.end())
                    take(found);
    }
    return out;
}

}  // namespace

std::vector<PointCluster> find_clusters(const pointcloud::PointSource& source,
                                        const KeepsPoint& keeps, double unit_m, int threads) {
    const auto ranges = source.parts(kPointsPerScan);
    Cells cells;
    std::mutex mutex;
    thread::parallel_for(ranges.size(), threads, [&](std::size_t i) {
        const Cells mine = cells_of(source, ranges[i], keeps, kCell_m / unit_m);
        const std::lock_guard lock(mutex);
        add_all(cells, mine, source);
    });
    std::vector<PointCluster> out;
    while (!cells.empty())
        out.push_back(take_cluster(cells));
    std::sort(out.begin(), out.end(), [](const PointCluster& a, const PointCluster& b) {
        return std::tie(b.count, a.min) < std::tie(a.count, b.min);
    });
    return out;
}

void drop_strays(std::vector<PointCluster>& clusters, double unit_m) {
    constexpr std::uint64_t kShare = 100;
    constexpr std::uint64_t kFew = 100;
    constexpr double kOnePlace_m = 10;
    std::uint64_t all = 0;
    for (const PointCluster& c : clusters)
        all += c.count;
    const auto stray = [&](const PointCluster& c) {
        const bool one_place = (c.max[0] - c.min[0]) * unit_m < kOnePlace_m &&
                               (c.max[1] - c.min[1]) * unit_m < kOnePlace_m;
        return c.count <= all / kShare && (c.count < kFew || one_place);
    };
    if (!clusters.empty())
        clusters.erase(std::remove_if(clusters.begin() + 1, clusters.end(), stray), clusters.end());
}

}  // namespace terravox::voxelize
