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
    std::vector<VoxelPoint> points;
};

// A total order by all members that later steps use, so that the order of points in the file cannot
// matter.
bool before(const VoxelPoint& a, const VoxelPoint& b) noexcept {
    const auto rest = [](const VoxelPoint& p) {
        return std::uint64_t{p.source_class} << 56 | std::uint64_t{p.colour.r} << 48 |
               std::uint64_t{p.colour.g} << 40 | std::uint64_t{p.colour.b} << 32 |
               std::uint64_t{p.x} << 16 | p.z;
    };
    return a.y != b.y ? a.y < b.y : rest(a) < rest(b);
}

// Counting sort by column, then each column by height.
void sort_patch(std::span<VoxelPoint> points, std::vector<VoxelPoint>& scratch) {
    std::array<std::uint32_t, grid::kPatchColumns + 1> begin{};
    for (const VoxelPoint& p : points)
        ++begin[static_cast<std::size_t>(p.column()) + 1];
    for (std::size_t i = 0; i < grid::kPatchColumns; ++i)
        begin[i + 1] += begin[i];
    scratch.resize(points.size());
    auto next = begin;
    for (const VoxelPoint& p : points)
        scratch[next[static_cast<std::size_t>(p.column())]++] = p;
    for (std::size_t i = 0; i < grid::kPatchColumns; ++i) {
        const auto from = scratch.begin() + begin[i];
        const auto to = scratch.begin() + begin[i + 1];
        constexpr std::ptrdiff_t kFew = 16;
        if (to - from > kFew) {
            std::sort(from, to, before);
            continue;
        }
        for (auto p = from; p < to; ++p) {  // insertion sort: columns have only a few points
            const VoxelPoint point = *p;
            auto q = p;
            for (; q > from && before(point, *(q - 1)); --q)
                *q = *(q - 1);
            *q = point;
        }
    }
    std::copy(scratch.begin(), scratch.end(), points.begin());
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
    // Step 1: find the patches, and count the points of each part in them.
    std::vector<grid::PatchKey> keys;
    for (const PatchedPoints& part : parts)
        for (const auto& run : part.runs)
            keys.push_back(run.patch);
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    std::unordered_map<grid::PatchKey, std::size_t, grid::PatchKeyHash> index_of(keys.size());
    for (std::size_t k = 0; k < keys.size(); ++k)
        index_of.emplace(keys[k], k);
    const auto run_end = [](const PatchedPoints& part, std::size_t r) {
        return r + 1 < part.runs.size() ? part.runs[r + 1].begin : part.points.size();
    };
    std::vector<std::size_t> next(keys.size());
    for (PatchedPoints& part : parts)
        for (std::size_t r = 0; r < part.runs.size(); ++r) {
            part.runs[r].place = index_of.at(part.runs[r].patch);
            next[part.runs[r].place] += run_end(part, r) - part.runs[r].begin;
        }
    std::size_t total = 0;
    for (std::size_t k = 0; k < keys.size(); ++k) {
        owned->patches.push_back({keys[k], total, next[k], 0});
        total += std::exchange(next[k], total);
    }
    // Step 2: move the points to their places. Runs get them one after the other, then they are
    // copied in parallel.
    for (PatchedPoints& part : parts)
        for (std::size_t r = 0; r < part.runs.size(); ++r) {
            std::size_t& to = next[part.runs[r].place];
            part.runs[r].place = std::exchange(to, to + run_end(part, r) - part.runs[r].begin);
        }
    owned->points.resize(total);
    thread::parallel_for(parts.size(), threads, [&](std::size_t i) {
        for (std::size_t r = 0; r < parts[i].runs.size(); ++r) {
            const auto from = parts[i].points.begin();
            std::copy(from + static_cast<std::ptrdiff_t>(parts[i].runs[r].begin),
                      from + static_cast<std::ptrdiff_t>(run_end(parts[i], r)),
                      owned->points.begin() + static_cast<std::ptrdiff_t>(parts[i].runs[r].place));
        }
        parts[i] = {};
    });
    // Step 3: sort by column.
    thread::parallel_for(keys.size(), threads, [&](std::size_t k) {
        thread_local std::vector<VoxelPoint> scratch;
        sort_patch(
            std::span(owned->points).subspan(owned->patches[k].begin, owned->patches[k].count),
            scratch);
    });
    const std::size_t bytes = total * sizeof(VoxelPoint) + keys.size() * sizeof(PatchEntry);
    return std::make_shared<Square>(owned, owned->patches, owned->points, counts, bytes, true);
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
