#include "voxelserver/tools/laz/laz_commands.hpp"

#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "voxelserver/data/lidar/spatial_index.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::laz {
namespace {

constexpr std::uint64_t kPointsPerCell = 20'000;  ///< target; a chunk has 50,000
constexpr std::uint32_t kDeepestLevel = 7;        ///< 16,384 cells
constexpr std::uint64_t kFirstGap = 1000;  ///< points of other cells that an interval may include
constexpr std::size_t kMaxIntervals = 200'000;

struct Interval {
    std::uint32_t first = 0, last = 0;  ///< closed
};
struct Cell {
    std::uint32_t points = 0;
    std::vector<Interval> intervals;
};

/// Collects the intervals of all cells.
class Intervals {
public:
    void add(std::uint32_t cell, std::uint32_t point) {
        Cell& c = m_cells[cell];
        ++c.points;
        if (!c.intervals.empty() && point - c.intervals.back().last <= m_gap) {
            c.intervals.back().last = point;
            return;
        }
        c.intervals.push_back({point, point});
        if (++m_count > kMaxIntervals)
            merge();
    }
    [[nodiscard]] const std::map<std::uint32_t, Cell>& cells() const noexcept { return m_cells; }
    [[nodiscard]] std::size_t count() const noexcept { return m_count; }

private:
    // At least halves the number, or leaves one interval per cell: the gap ends at 2^32, more than
    // the distance of any two points.
    void merge() {
        while (m_count > kMaxIntervals / 2 && m_gap < std::uint64_t{1} << 32) {
            m_gap *= 2;
            m_count = 0;
            for (auto& [number, cell] : m_cells) {
                std::vector<Interval> merged;
                for (const Interval& next : cell.intervals) {
                    if (!merged.empty() && next.first - merged.back().last <= m_gap)
                        merged.back().last = next.last;
                    else
                        merged.push_back(next);
                }
                merged.shrink_to_fit();
                cell.intervals = std::move(merged);
                m_count += cell.intervals.size();
            }
        }
    }
    std::map<std::uint32_t, Cell> m_cells;
    std::size_t m_count = 0;
    std::uint64_t m_gap = kFirstGap;
};

/// Bisects the bounds level by level, with 32-bit numbers and comparing with the midpoints only, as
/// readers of the format do.
class Quadtree {
public:
    explicit Quadtree(const lidar::LasInfo& info)
        : m_min_x(static_cast<float>(info.min[0])),
          m_max_x(static_cast<float>(info.max[0])),
          m_min_y(static_cast<float>(info.min[1])),
          m_max_y(static_cast<float>(info.max[1])) {
        for (std::uint64_t cells = 1;
             m_levels < kDeepestLevel && info.point_count > cells * kPointsPerCell; cells *= 4)
            ++m_levels;
        for (std::uint32_t level = 0; level < m_levels; ++level)
            m_first += 1U << (2 * level);
    }
    [[nodiscard]] std::uint32_t find_cell(double x, double y) const noexcept {
        float min_x = m_min_x;
        float max_x = m_max_x;
        float min_y = m_min_y;
        float max_y = m_max_y;
        std::uint32_t within = 0;
        for (std::uint32_t level = 0; level < m_levels; ++level) {
            const float mid_x = (min_x + max_x) / 2;
            const float mid_y = (min_y + max_y) / 2;
            const bool east = !(x < static_cast<double>(mid_x));
            const bool north = !(y < static_cast<double>(mid_y));
            (east ? min_x : max_x) = mid_x;
            (north ? min_y : max_y) = mid_y;
            within = within << 2 | (north ? 2U : 0U) | (east ? 1U : 0U);
        }
        return m_first + within;
    }
    [[nodiscard]] std::uint32_t levels() const noexcept { return m_levels; }
    [[nodiscard]] std::array<float, 4> bounds() const noexcept {
        return {m_min_x, m_max_x, m_min_y, m_max_y};
    }

private:
    float m_min_x;
    float m_max_x;
    float m_min_y;
    float m_max_y;
    std::uint32_t m_levels = 0;
    std::uint32_t m_first = 0;
};

class Bytes {
public:
    void sign(const char* four) { m_bytes.append(four, 4); }
    template <class T>
    void put(T value) {
        char raw[sizeof value];
        std::memcpy(raw, &value, sizeof value);
        m_bytes.append(raw, sizeof value);
    }
    [[nodiscard]] const std::string& all() const noexcept { return m_bytes; }

private:
    std::string m_bytes;
};

std::string lax_bytes(const Quadtree& tree, const Intervals& found) {
    Bytes out;
    const std::uint32_t version = 0;
    const std::uint32_t quadtree = 0;
    const std::uint32_t whole_file = 0;
    out.sign("LASX");
    out.put(version);
    out.sign("LASS");
    out.put(quadtree);
    out.sign("LASQ");
    out.put(version);
    out.put(tree.levels());
    out.put(whole_file);
    out.put(whole_file);
    for (const float bound : tree.bounds())
        out.put(bound);
    out.sign("LASV");
    out.put(version);
    out.put(static_cast<std::uint32_t>(found.cells().size()));
    for (const auto& [number, cell] : found.cells()) {
        out.put(static_cast<std::int32_t>(number));
        out.put(static_cast<std::uint32_t>(cell.intervals.size()));
        out.put(cell.points);
        for (const Interval& interval : cell.intervals) {
            out.put(interval.first);
            out.put(interval.last);
        }
    }
    return out.all();
}

}  // namespace

Indexed write_lax(const std::filesystem::path& cloud) {
    const lidar::LasInfo info = lidar::read_las_info(cloud);
    const pointcloud::FileBytes file(cloud);
    if (info.point_count == 0)
        file.fail("no points to index; allowed: 1 or more");
    if (lidar::read_copc_index(info))
        file.fail("a COPC file has its own index; allowed: other LAS and LAZ files");
    const Quadtree tree(info);
    Intervals found;
    std::uint32_t at = 0;
    const lidar::PointRange all{0, info.point_count};
    lidar::read_point_batches(info, {&all, 1}, [&](std::span<const lidar::RawPoint> batch) {
        for (const lidar::RawPoint& p : batch)
            found.add(tree.find_cell(p.x * info.scale[0] + info.offset[0],
                                     p.y * info.scale[1] + info.offset[1]),
                      at++);
    });
    const std::filesystem::path path = lidar::lax_path(cloud);
    const std::string bytes = lax_bytes(tree, found);
    util::write_file_atomically(path, bytes);
    (void)lidar::read_lax_index(info);
    return {path, bytes.size(), found.cells().size(), found.count()};
}

}  // namespace terravox::laz
