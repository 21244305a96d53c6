#include "voxelserver/data/store/square.hpp"

#include <xxhash.h>
#include <algorithm>
#include <unordered_map>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/util/files.hpp"

namespace terravox::store {
namespace {

/// The memory that a square made in memory owns.
struct Owned {
    std::vector<PatchEntry> patches;
    std::unique_ptr<std::byte[]> points;
};

/// A point as numbers that rank as points do: by height, then by all that later steps use, so that
/// the order of points in the file cannot matter.
struct Ranked {
    std::uint64_t high = 0;   ///< height, class and colour
    std::uint32_t low = 0;    ///< x and z
    std::uint32_t place = 0;  ///< in its column, once found; no part of the rank

    Ranked() = default;
    explicit Ranked(const VoxelPoint& p) noexcept
        : high(std::uint64_t{static_cast<std::uint32_t>(p.y) ^ kSign} << 32 |
               std::uint64_t{p.source_class} << 24 | std::uint64_t{p.colour.r} << 16 |
               std::uint64_t{p.colour.g} << 8 | p.colour.b),
          low(std::uint32_t{p.x} << 16 | p.z) {}
    [[nodiscard]] VoxelPoint point() const noexcept {
        VoxelPoint out;
        out.x = static_cast<std::uint16_t>(low >> 16);
        out.z = static_cast<std::uint16_t>(low);
        out.y = static_cast<std::int32_t>(static_cast<std::uint32_t>(high >> 32) ^ kSign);
        const auto byte = [&](int shift) { return static_cast<std::uint8_t>(high >> shift); };
        out.source_class = byte(24);
        out.colour = {byte(16), byte(8), byte(0)};
        return out;
    }
    friend bool operator<(const Ranked& a, const Ranked& b) noexcept {
        return (a.high < b.high) | ((a.high == b.high) & (a.low < b.low));
    }

private:
    static constexpr std::uint32_t kSign = 1U << 31;
};

// Most columns have a few points: counting which of two comes first, for all pairs, guesses no
// branch wrong.
void sort_column(std::span<Ranked> points, VoxelPoint* out) {
    constexpr std::size_t kFew = 24;
    if (points.size() > kFew) {
        std::sort(points.begin(), points.end());
        for (const Ranked& p : points)
            *out++ = p.point();
        return;
    }
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::uint32_t before = 0;
        for (std::size_t j = 0; j < i; ++j) {
            const std::uint32_t later = points[i] < points[j] ? 1 : 0;
            points[j].place += later;
            before += 1 - later;
        }
        points[i].place = before;
    }
    for (const Ranked& p : points)
        out[p.place] = p.point();
}

// Counting sort by column, then each column.
void sort_patch(std::span<const std::span<const VoxelPoint>> runs, std::vector<Ranked>& scratch,
                std::span<VoxelPoint> out) {
    std::array<std::uint32_t, grid::kPatchColumns + 1> begin{};
    for (const auto& run : runs)
        for (const VoxelPoint& p : run)
            ++begin[static_cast<std::size_t>(p.column()) + 1];
    for (std::size_t i = 0; i < grid::kPatchColumns; ++i)
        begin[i + 1] += begin[i];
    scratch.resize(out.size());
    auto next = begin;
    for (const auto& run : runs)
        for (const VoxelPoint& p : run)
            scratch[next[static_cast<std::size_t>(p.column())]++] = Ranked(p);
    for (std::size_t i = 0; i < grid::kPatchColumns; ++i)
        sort_column(std::span(scratch).subspan(begin[i], begin[i + 1] - begin[i]),
                    out.data() + begin[i]);
}

}  // namespace

void PointCounts::add(const PointCounts& other) noexcept {
    kept += other.kept;
    outliers += other.outliers;
    withheld += other.withheld;
    noise += other.noise;
    for (std::size_t i = 0; i < by_class.size(); ++i)
        by_class[i] += other.by_class[i];
}

std::uint64_t compute_checksum(std::span<const VoxelPoint> points) noexcept {
    return XXH64(points.data(), points.size_bytes(), 0);
}

std::span<const VoxelPoint> Square::points(grid::PatchKey patch) const {
    const auto found =
        std::lower_bound(m_patches.begin(), m_patches.end(), patch,
                         [](const PatchEntry& e, const grid::PatchKey& k) { return e.key < k; });
    if (found == m_patches.end() || !(found->key == patch))
        return {};
    const auto out = m_points.subspan(found->begin, found->count);
    // Checks first whether the file was truncated in place, since accessing a lost page would end
    // the program.
    if (!m_checked &&
        (!util::readable(std::as_bytes(out)) || compute_checksum(out) != found->checksum))
        throw util::Error(
            "read a prepared square: patch {}, {} is damaged on disk; remove the cache folder",
            patch.px, patch.pz);
    return out;
}

std::shared_ptr<const Square> bin_points(std::vector<PatchedPoints> parts,
                                         const PointCounts& counts, int threads) {
    const auto owned = std::make_shared<Owned>();
    // Step 1: find the patches.
    std::vector<grid::PatchKey> keys;
    for (const PatchedPoints& part : parts)
        for (const auto& run : part.runs)
            keys.push_back(run.patch);
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    std::unordered_map<grid::PatchKey, std::size_t, grid::PatchKeyHash> index_of(keys.size());
    for (std::size_t k = 0; k < keys.size(); ++k)
        index_of.emplace(keys[k], k);
    // Step 2: list the runs of each patch.
    std::vector<std::vector<std::span<const VoxelPoint>>> runs(keys.size());
    for (const PatchedPoints& part : parts)
        for (std::size_t r = 0; r < part.runs.size(); ++r) {
            const std::size_t begin = part.runs[r].begin;
            const std::size_t end =
                r + 1 < part.runs.size() ? part.runs[r + 1].begin : part.points.size();
            runs[index_of.at(part.runs[r].patch)].push_back(
                std::span(part.points).subspan(begin, end - begin));
        }
    std::size_t total = 0;
    for (std::size_t k = 0; k < keys.size(); ++k) {
        std::size_t count = 0;
        for (const auto& run : runs[k])
            count += run.size();
        owned->patches.push_back({keys[k], total, count, 0});
        total += count;
    }
    // Step 3: sort by column, into memory that nothing was written to before.
    owned->points = std::make_unique_for_overwrite<std::byte[]>(total * sizeof(VoxelPoint));
    const std::span points(reinterpret_cast<VoxelPoint*>(owned->points.get()), total);
    thread::parallel_for(keys.size(), threads, [&](std::size_t k) {
        thread_local std::vector<Ranked> scratch;
        sort_patch(runs[k], scratch,
                   points.subspan(owned->patches[k].begin, owned->patches[k].count));
    });
    const std::size_t bytes = total * sizeof(VoxelPoint) + keys.size() * sizeof(PatchEntry);
    return std::make_shared<Square>(owned, owned->patches, points, counts, bytes, true);
}

std::vector<std::size_t> ChunkIndex::over(const grid::PatchRect& rect) const {
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < m_chunks.size(); ++i)
        if (std::any_of(m_chunks[i].patches.begin(), m_chunks[i].patches.end(),
                        [&](grid::PatchKey k) { return rect.contains(k); }))
            out.push_back(i);
    return out;
}

std::vector<pointcloud::PointRange> ChunkIndex::ranges_over(const grid::PatchRect& rect) const {
    std::vector<pointcloud::PointRange> out;
    for (const std::size_t i : over(rect)) {
        if (!out.empty() && out.back().end == m_chunks[i].points.begin)
            out.back().end = m_chunks[i].points.end;
        else
            out.push_back(m_chunks[i].points);
    }
    return out;
}

}  // namespace terravox::store
