#include "voxelserver/data/lidar/spatial_index.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include "common/util/error.hpp"
#include "voxelserver/data/lidar/chunk_table.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::lidar {
namespace {

constexpr std::uint32_t kDeepestLevel = 15;  ///< cells are numbered with 31 bits, level by level
constexpr double kInfinite = std::numeric_limits<double>::infinity();

class LaxFile {
public:
    LaxFile(const std::filesystem::path& path, const LasInfo& info) : m_path(path), m_info(info) {
        const pointcloud::FileBytes file(path);
        // Each interval holds at least one point of its own, each cell at least one interval.
        const std::uint64_t max_bytes = 64 + info.point_count * 20;
        if (file.size() > max_bytes)
            fail(std::to_string(file.size()) + " bytes; an index of " +
                 std::to_string(info.point_count) + " points has at most " +
                 std::to_string(max_bytes));
        m_bytes.resize(file.size());
        file.read(0, m_bytes);
    }

    std::vector<SpatialIndex::Cell> read() {
        read_tree();
        expect("LASV");
        skip(4);  // version
        const auto cells = next<std::uint32_t>();
        for (std::uint32_t i = 0; i < cells; ++i)
            read_cell();
        if (m_at != m_bytes.size())
            fail(std::to_string(m_bytes.size() - m_at) + " bytes behind its last cell");
        check_whole();
        return std::move(m_cells);
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        throw util::Error("read the spatial index {}: {}", m_path.string(), what);
    }
    void skip(std::size_t count) {
        if (m_bytes.size() - m_at < count)
            fail("cut short: " + std::to_string(m_bytes.size()) + " bytes");
        m_at += count;
    }
    template <class T>
    T next() {
        T value;
        skip(sizeof value);
        std::memcpy(&value, m_bytes.data() + m_at - sizeof value, sizeof value);
        return value;
    }
    bool skip_if(const char* sign) {
        const bool found =
            m_bytes.size() - m_at >= 4 && std::memcmp(m_bytes.data() + m_at, sign, 4) == 0;
        if (found)
            m_at += 4;
        return found;
    }
    void expect(const char* sign) {
        if (!skip_if(sign))
            fail(std::string("'") + sign + "' expected at byte " + std::to_string(m_at));
    }

    void read_tree() {
        expect("LASX");
        skip(4);  // version
        expect("LASS");
        if (const auto kind = next<std::uint32_t>(); kind != 0)
            fail("spatial index of kind " + std::to_string(kind) + "; allowed: 0 (a quadtree)");
        if (skip_if("LASQ"))
            skip(4);  // version; missing in the oldest files
        m_levels = next<std::uint32_t>();
        if (m_levels > kDeepestLevel)
            fail(std::to_string(m_levels) + " levels; allowed: up to " +
                 std::to_string(kDeepestLevel));
        skip(8);  // two fields for trees split over several files, which LASindex ignores as well
        for (float* const bound : {&m_min_x, &m_max_x, &m_min_y, &m_max_y}) {
            *bound = next<float>();
            if (!std::isfinite(*bound))
                fail("bounds are not finite numbers");
        }
    }

    // The writer chose cells by bisection with 32-bit numbers, and compared only with the
    // midpoints: points outside of the tree are in its outer cells.
    SpatialIndex::Cell measure_bounds(std::uint32_t number) const {
        std::uint32_t level = 0;
        std::uint32_t within = number;
        for (; within >= std::uint64_t{1} << (2 * level); ++level)
            within -= 1U << (2 * level);
        if (level > m_levels)
            fail("cell " + std::to_string(number) + " on level " + std::to_string(level) + " of " +
                 std::to_string(m_levels));
        SpatialIndex::Cell cell{-kInfinite, -kInfinite, kInfinite, kInfinite, {}};
        float min_x = m_min_x;
        float max_x = m_max_x;
        float min_y = m_min_y;
        float max_y = m_max_y;
        while (level-- > 0) {
            const std::uint32_t quarter = within >> (2 * level) & 3;
            const float mid_x = (min_x + max_x) / 2;
            const float mid_y = (min_y + max_y) / 2;
            if ((quarter & 1) != 0)
                cell.min_x = min_x = mid_x;
            else
                cell.max_x = max_x = mid_x;
            if ((quarter & 2) != 0)
                cell.min_y = min_y = mid_y;
            else
                cell.max_y = max_y = mid_y;
        }
        return cell;
    }

    void read_cell() {
        const auto number = next<std::int32_t>();
        if (number < 0)
            fail("cell " + std::to_string(number) + "; allowed: from 0");
        SpatialIndex::Cell cell = measure_bounds(static_cast<std::uint32_t>(number));
        const auto intervals = next<std::uint32_t>();
        m_points += next<std::uint32_t>();
        std::uint64_t next_free = 0;
        for (std::uint32_t i = 0; i < intervals; ++i) {
            const std::uint64_t begin = next<std::uint32_t>();
            const std::uint64_t last = next<std::uint32_t>();
            if (begin < next_free || last < begin || last >= m_info.point_count)
                fail("points " + std::to_string(begin) + " to " + std::to_string(last) +
                     " in cell " + std::to_string(number) + "; allowed: " +
                     std::to_string(next_free) + " to " + std::to_string(m_info.point_count - 1));
            next_free = last + 1;
            cell.points = {begin, last + 1};
            m_cells.push_back(cell);
        }
    }

    void check_whole() const {
        if (m_points != m_info.point_count)
            fail("it is of " + std::to_string(m_points) + " points; the point cloud has " +
                 std::to_string(m_info.point_count));
        std::vector<PointRange> ranges;
        for (const auto& cell : m_cells)
            ranges.push_back(cell.points);
        std::sort(ranges.begin(), ranges.end(),
                  [](const PointRange& a, const PointRange& b) { return a.begin < b.begin; });
        std::uint64_t held = 0;
        for (const PointRange& range : ranges) {
            if (range.begin > held)
                break;
            held = std::max(held, range.end);
        }
        if (held != m_info.point_count)
            fail("point " + std::to_string(held) + " is in no cell");
    }

    std::filesystem::path m_path;
    const LasInfo& m_info;
    std::vector<unsigned char> m_bytes;
    std::size_t m_at = 0;
    std::uint32_t m_levels = 0;
    float m_min_x = 0;
    float m_max_x = 0;
    float m_min_y = 0;
    float m_max_y = 0;
    std::uint64_t m_points = 0;
    std::vector<SpatialIndex::Cell> m_cells;
};

}  // namespace

std::filesystem::path lax_path(const std::filesystem::path& cloud) {
    std::filesystem::path out = cloud;
    return out.replace_extension(".lax");
}

std::optional<std::vector<SpatialIndex::Cell>> read_lax_index(const LasInfo& info) {
    const std::filesystem::path path = lax_path(info.path);
    std::error_code failed;
    if (!std::filesystem::exists(path, failed))
        return std::nullopt;
    return LaxFile(path, info).read();
}

namespace {

// An index that belongs to another file may happen to have the same number of points. Checks the
// first points of some chunks, which is cheap.
void check_by_points(const LasInfo& info, const SpatialIndex& index) {
    constexpr std::uint64_t kLookUps = 16;
    constexpr std::uint64_t kPointsEach = 16;
    const auto pieces = split_by_chunk(info, 1);
    std::vector<PointRange> firsts;
    for (std::size_t i = 0; i < pieces.size(); i += pieces.size() / kLookUps + 1)
        firsts.push_back({pieces[i].begin, std::min(pieces[i].begin + kPointsEach, pieces[i].end)});
    std::vector<std::uint64_t> numbers;
    for (const PointRange& range : firsts)
        for (std::uint64_t i = range.begin; i < range.end; ++i)
            numbers.push_back(i);
    auto number = numbers.begin();
    read_point_batches(info, firsts, [&](std::span<const RawPoint> batch) {
        for (const RawPoint& p : batch) {
            const double x = p.x * info.scale[0] + info.offset[0];
            const double y = p.y * info.scale[1] + info.offset[1];
            const std::uint64_t wanted = *number++;
            const auto ranges = index.ranges_over(x, y, x, y);
            if (std::none_of(ranges.begin(), ranges.end(), [&](const PointRange& r) {
                    return r.begin <= wanted && wanted < r.end;
                }))
                throw util::Error(
                    "read {}: by it point {} of {} lies elsewhere; one of the two is damaged, or "
                    "they do not belong together",
                    index.source(), wanted, info.path.string());
        }
    });
}

}  // namespace

std::shared_ptr<const SpatialIndex> read_spatial_index(const LasInfo& info) {
    if (info.point_count == 0)
        return nullptr;
    std::shared_ptr<const SpatialIndex> index;
    if (auto copc = read_copc_index(info))
        index = std::make_shared<const SpatialIndex>(
            std::move(copc->cells), "the COPC hierarchy of " + info.path.string(), true);
    else if (auto cells = read_lax_index(info))
        index = std::make_shared<const SpatialIndex>(std::move(*cells),
                                                     lax_path(info.path).string(), false);
    if (index)
        check_by_points(info, *index);
    return index;
}

}  // namespace terravox::lidar
