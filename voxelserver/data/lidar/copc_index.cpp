#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <unordered_set>

#include "voxelserver/data/lidar/chunk_table.hpp"
#include "voxelserver/data/lidar/las_header.hpp"
#include "voxelserver/data/lidar/spatial_index.hpp"
#include "voxelserver/data/pointcloud/file_bytes.hpp"

namespace terravox::lidar {
namespace {

constexpr std::uint64_t kEntryBytes = 32;
constexpr std::int32_t kAnotherPage = -1;
constexpr int kDeepestNode = 30;  ///< 2^30 nodes along an axis: 1 mm in 1000 km

struct Page {
    std::uint64_t at = 0;
    std::uint64_t bytes = 0;
};

struct Entry {
    std::array<std::int32_t, 4> key;  ///< level, x, y, z
    std::uint64_t at;
    std::int32_t bytes;
    std::int32_t points;
};
static_assert(sizeof(Entry) == kEntryBytes);

class Hierarchy {
public:
    Hierarchy(const pointcloud::FileBytes& file, const LasInfo& info, std::uint64_t info_at)
        : m_file(file), m_info(info), m_seen(info.chunks->size()) {
        const auto centre = file.at<std::array<double, 3>>(info_at);
        m_half = file.at<double>(info_at + 24);
        for (std::size_t axis = 0; axis < 3; ++axis)
            m_low[axis] = centre[axis] - m_half;
        m_root = {file.at<std::uint64_t>(info_at + 40), file.at<std::uint64_t>(info_at + 48)};
        check_cube();
    }

    CopcIndex read() {
        std::vector<Page> pages = {m_root};
        while (!pages.empty()) {
            const Page page = pages.back();
            pages.pop_back();
            for (const Entry& entry : read_page(page)) {
                check_key(entry);
                if (entry.points == kAnotherPage)
                    pages.push_back(
                        {entry.at, entry.bytes < 0 ? 0 : static_cast<std::uint64_t>(entry.bytes)});
                else if (entry.points != 0)
                    add(entry);
            }
        }
        std::size_t chunks = 0;
        for (std::size_t i = 0; i < m_seen.size(); ++i)
            chunks += m_info.chunks->empty_chunk(i) ? 0 : 1;
        if (m_index.cells.size() != chunks)
            fail(std::to_string(m_index.cells.size()) + " nodes with points; the file has " +
                 std::to_string(chunks) + " chunks with points");
        return std::move(m_index);
    }

private:
    [[noreturn]] void fail(const std::string& what) const {
        m_file.fail("damaged COPC hierarchy: " + what);
    }

    // Points are found by the cube of their node, so the cube must contain all of them. A
    // difference of one rounding step is accepted.
    void check_cube() const {
        bool right = std::isfinite(m_half) && m_half > 0;
        for (std::size_t axis = 0; axis < 3 && right; ++axis) {
            const double slack = m_half * 1e-6 + m_info.scale[axis];
            right = m_low[axis] - slack <= m_info.min[axis] &&
                    m_info.max[axis] <= m_low[axis] + 2 * m_half + slack;
        }
        if (!right)
            fail("its cube of half size " + std::to_string(m_half) +
                 " does not hold the bounds of the file");
    }

    std::vector<Entry> read_page(Page page) {
        // Pages that are visited twice (a cycle) or overlap would take for ever: their total size
        // must not exceed that of the file.
        m_bytes += page.bytes;
        if (page.bytes == 0 || page.bytes % kEntryBytes != 0 || page.bytes > m_file.size() ||
            m_bytes > m_file.size() || !m_pages.insert(page.at).second)
            fail("page of " + std::to_string(page.bytes) + " bytes at byte " +
                 std::to_string(page.at) + " (allowed: whole entries of 32 bytes, each page once)");
        std::vector<Entry> entries(page.bytes / kEntryBytes);
        m_file.read(page.at, {reinterpret_cast<unsigned char*>(entries.data()), page.bytes});
        return entries;
    }

    void check_key(const Entry& entry) const {
        const std::int64_t nodes = std::int64_t{1} << std::clamp(entry.key[0], 0, kDeepestNode);
        bool right =
            entry.key[0] >= 0 && entry.key[0] <= kDeepestNode && entry.points >= kAnotherPage;
        for (std::size_t axis = 0; axis < 3; ++axis)
            right = right && entry.key[axis + 1] >= 0 && entry.key[axis + 1] < nodes;
        if (!right)
            fail("node " + std::to_string(entry.key[0]) + "-" + std::to_string(entry.key[1]) + "-" +
                 std::to_string(entry.key[2]) + "-" + std::to_string(entry.key[3]) + " of " +
                 std::to_string(entry.points) + " points");
    }

    void add(const Entry& entry) {
        const ChunkTable& chunks = *m_info.chunks;
        const auto found =
            std::lower_bound(chunks.first_byte.begin(), chunks.first_byte.end() - 1, entry.at);
        const auto chunk = static_cast<std::size_t>(found - chunks.first_byte.begin());
        if (chunk == chunks.size() || *found != entry.at || m_seen[chunk])
            fail("a node at byte " + std::to_string(entry.at) +
                 ", where no chunk begins or a node is already");
        const PointRange points{chunks.first_point[chunk], chunks.first_point[chunk + 1]};
        if (entry.points < 0 ||
            static_cast<std::uint64_t>(entry.points) != points.end - points.begin ||
            entry.bytes < 0 ||
            static_cast<std::uint64_t>(entry.bytes) != chunks.first_byte[chunk + 1] - entry.at)
            fail("a node of " + std::to_string(entry.points) + " points in " +
                 std::to_string(entry.bytes) + " bytes; chunk " + std::to_string(chunk) + " has " +
                 std::to_string(points.end - points.begin) + " in " +
                 std::to_string(chunks.first_byte[chunk + 1] - entry.at));
        m_seen[chunk] = true;
        // Writers round coordinates after they have chosen the node: one step of tolerance on each
        // side.
        const double size = std::ldexp(2 * m_half, -entry.key[0]);
        const double x = m_low[0] + entry.key[1] * size;
        const double y = m_low[1] + entry.key[2] * size;
        const double pad_x = m_info.scale[0] + size * 1e-6;
        const double pad_y = m_info.scale[1] + size * 1e-6;
        m_index.cells.push_back({x - pad_x, y - pad_y, x + size + pad_x, y + size + pad_y, points});
        if (entry.key[0] == 0)
            m_index.root = points;
    }

    const pointcloud::FileBytes& m_file;
    const LasInfo& m_info;
    std::vector<bool> m_seen;
    std::array<double, 3> m_low{};
    double m_half = 0;
    Page m_root;
    std::uint64_t m_bytes = 0;
    std::unordered_set<std::uint64_t> m_pages;
    CopcIndex m_index;
};

}  // namespace

std::optional<CopcIndex> read_copc_index(const LasInfo& info) {
    constexpr std::uint16_t kInfoBytes = 160;
    const pointcloud::FileBytes file(info.path);
    const auto records = read_records(file);
    const auto found = std::find_if(records.begin(), records.end(), [](const VariableRecord& r) {
        return r.id == 1 && r.user == "copc";
    });
    if (found == records.end() || info.point_count == 0)
        return std::nullopt;
    if (found->bytes != kInfoBytes || !info.chunks || info.point_format < 6)
        file.fail("damaged COPC hierarchy: a record of " + std::to_string(found->bytes) +
                  " bytes in a file of point format " + std::to_string(info.point_format) +
                  "; it needs 160 and compressed points of format 6-8");
    return Hierarchy(file, info, found->at).read();
}

}  // namespace terravox::lidar
