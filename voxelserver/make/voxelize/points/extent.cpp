#include "voxelserver/make/voxelize/points/extent.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <bitset>
#include <cmath>
#include <mutex>
#include <string>
#include <tuple>
#include <unordered_map>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"

namespace terravox::voxelize {
namespace {

using pointcloud::Point;
using pointcloud::PointCloudInfo;
using pointcloud::PointSource;
using Place = std::array<double, 3>;

double unit_m(const PointCloudInfo& info) {
    constexpr double kDegree_m = 111'320;  // of latitude; rough is enough here
    return info.crs->geographic() ? kDegree_m : info.crs->metres_per_unit();
}

std::string to_text(const Place& min, const Place& max) {
    return fmt::format("x {:.10g} to {:.10g}, y {:.10g} to {:.10g}, z {:.10g} to {:.10g}", min[0],
                       max[0], min[1], max[1], min[2], max[2]);
}

// What defines that the points of a file lie within its bounds.
const char* find_authority(const PointCloudInfo& info) {
    return info.measured_bounds ? "its points span the bounds" : "its header states the bounds";
}

[[noreturn]] void refuse(const PointCloudInfo& info, const std::string& why) {
    throw util::Error("place the point cloud {}: {} {}, {}; the header needs repair",
                      info.path.string(), find_authority(info), to_text(info.min, info.max), why);
}

Place find_place(const Point& p) {
    return {p.x, p.y, p.z};
}

// How many points lie beyond the bounds, by more than rounding.
std::size_t count_beyond(const PointCloudInfo& info, std::span<const Point> sample) {
    const Place slack{find_rounding(info, 0), find_rounding(info, 1), find_rounding(info, 2)};
    return static_cast<std::size_t>(
        std::count_if(sample.begin(), sample.end(), [&](const Point& p) {
            const Place at = find_place(p);
            for (std::size_t a = 0; a < 3; ++a)
                if (!(at[a] >= info.min[a] - slack[a] && at[a] <= info.max[a] + slack[a]))
                    return true;
            return false;
        }));
}

// A survey may be a thin strip, and a small sample may miss much of it: only bounds that are nearly
// empty justify reading the whole file.
bool looks_empty(const PointSource& source, const PointCloudInfo& info,
                 std::span<const Point> sample) {
    constexpr std::size_t kFewParts = 16, kHardlyAny = 4;  // of 64
    constexpr double kThin = 1;                            // points for a square metre
    const double unit = unit_m(info);
    const double area_m2 = (info.max[0] - info.min[0]) * unit * (info.max[1] - info.min[1]) * unit;
    const std::size_t met = parts_met(info, sample);
    const bool thin = static_cast<double>(info.point_count) < kThin * area_m2;
    return (met <= kFewParts && thin) ||
           (met <= kHardlyAny && source.sampled_all_over() && area_m2 > 0);
}

// A gap may be a river between its banks: only parts that lie far apart are separate.
std::vector<PlanRect> find_islands(const std::vector<PointCluster>& clusters, double unit) {
    constexpr double kApart_m = 5000;
    constexpr std::size_t kMax = 64;  // more parts than that are one survey
    const double apart = kApart_m / unit;
    std::vector<PlanRect> out;
    const auto join = [](PlanRect& to, const PlanRect& from) {
        to = {std::min(to.min_x, from.min_x), std::min(to.min_y, from.min_y),
              std::max(to.max_x, from.max_x), std::max(to.max_y, from.max_y)};
    };
    for (const PointCluster& c : clusters) {
        PlanRect rect{c.min[0], c.min[1], c.max[0], c.max[1]};
        // A merged rectangle may overlap another one.
        for (std::size_t i = 0; i < out.size();) {
            const PlanRect& o = out[i];
            if (rect.min_x - apart < o.max_x && o.min_x - apart < rect.max_x &&
                rect.min_y - apart < o.max_y && o.min_y - apart < rect.max_y) {
                join(rect, o);
                out.erase(out.begin() + static_cast<std::ptrdiff_t>(i));
                i = 0;
            } else {
                ++i;
            }
        }
        out.push_back(rect);
        if (out.size() > kMax) {
            for (const PointCluster& all : clusters)
                join(out.front(), {all.min[0], all.min[1], all.max[0], all.max[1]});
            return {out.front()};
        }
    }
    return out;
}

}  // namespace

double find_rounding(const PointCloudInfo& info, std::size_t axis) {
    constexpr double kDigits = 0.02;  // of a unit of height, of a metre in plan
    return std::max(axis == 2 ? kDigits : kDigits / unit_m(info), 2 * info.scale[axis]);
}

std::size_t parts_met(const PointCloudInfo& info, std::span<const Point> sample) {
    constexpr int kParts = 8;
    std::bitset<kParts * kParts> met;
    for (const Point& p : sample) {
        const Place at = find_place(p);
        const auto part = [&](std::size_t a) {
            const double width = info.max[a] - info.min[a];
            return width > 0 ? static_cast<std::size_t>(std::clamp(
                                   (at[a] - info.min[a]) / width * kParts, 0.0, kParts - 1.0))
                             : 0;
        };
        met.set(part(1) * kParts + part(0));
    }
    return met.count();
}

std::vector<PlanRect> settle_extent(const PointSource& source, PointCloudInfo& info,
                                    std::span<const Point> sample, const KeepsPoint& keeps,
                                    int threads) {
    for (std::size_t a = 0; a < 3; ++a)
        if (info.min[a] > info.max[a])
            refuse(info, "minimum above maximum");
    const std::size_t beyond = count_beyond(info, sample);
    if (!sample.empty() && beyond == sample.size())
        refuse(info,
               "none of the " + std::to_string(sample.size()) + " sampled points lies within them");
    const std::vector<PlanRect> stated{{info.min[0], info.min[1], info.max[0], info.max[1]}};
    if (sample.empty() || (beyond == 0 && !looks_empty(source, info, sample)))
        return stated;

    const double unit = unit_m(info);
    auto clusters = find_clusters(source, keeps, unit, threads);
    if (clusters.empty())
        return stated;
    const std::size_t all = clusters.size();
    drop_strays(clusters, unit);
    Place min = clusters.front().min;
    Place max = clusters.front().max;
    for (const PointCluster& c : clusters)
        for (std::size_t a = 0; a < 3; ++a) {
            min[a] = std::min(min[a], c.min[a]);
            max[a] = std::max(max[a], c.max[a]);
        }
    // Bounds may be those of a whole square of which only a part was surveyed.
    constexpr double kMuch_m = 1000;
    bool wrong = beyond > 0 || clusters.size() < all;
    for (std::size_t a = 0; a < 2; ++a)
        wrong = wrong || (min[a] - info.min[a]) * unit > kMuch_m ||
                (info.max[a] - max[a]) * unit > kMuch_m;
    if (wrong) {
        util::warn_of_file(
            info.path.string(),
            info.measured_bounds
                ? "its points span the bounds with strays only; those of the others are used"
                : "its header states the bounds wrongly; those of its points are used",
            fmt::format("{}, points in {}", to_text(info.min, info.max), to_text(min, max)));
        info.min = min;
        info.max = max;
    }
    auto islands = find_islands(clusters, unit);
    return wrong || islands.size() > 1 ? islands : stated;
}

namespace {

constexpr double kCell_m = 256;
constexpr int kReach = 4;                     // cells: clusters are a kilometre apart or more
constexpr std::size_t kMaxCells = 1'000'000;  // 65,000 square kilometres; some tens of MB
constexpr std::uint64_t kPointsPerScan = 200'000;

using Cells = std::unordered_map<std::uint64_t, PointCluster>;

std::uint64_t to_key(std::int64_t i, std::int64_t k) noexcept {
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
        throw util::Error(
            "place the point cloud {}: its points are strewn over more than {} squares of 256 m",
            source.info().path.string(), kMaxCells);
}

// Neighbours in a file are neighbours in space: the cell is mostly that of the previous point.
Cells collect_cells(const pointcloud::PointSource& source, const pointcloud::PointRange& range,
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
            const std::uint64_t key = to_key(index(at[0]), index(at[1]));
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
                        left.find(to_key(std::int64_t{i} + di, std::int64_t{k} + dk));
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
        const Cells mine = collect_cells(source, ranges[i], keeps, kCell_m / unit_m);
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
