#include "voxelserver/voxelize/square.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "common/thread/parallel.hpp"
#include "common/util/error.hpp"
#include "common/voxel/morton.hpp"

namespace terravox::voxelize {
namespace {

constexpr std::uint64_t kPointsPerRange = 100'000;
constexpr int kPatchShift = VoxelPoint::kFractionBits + 6;
constexpr double kFractionOne = 1 << VoxelPoint::kFractionBits;

/// Turns file coordinates into fixed point; counts what cannot be placed.
class Placer {
public:
    Placer(const SquareSource& source, const Frame& frame, Base base) : m_source(source), m_frame(frame), m_base(base) {
        // Points a little outside the stated bounds are rounding; far outside they are errors of the survey.
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double slack = std::max(1.0, 0.01 * (source.info.max[axis] - source.info.min[axis]));
            m_min[axis] = source.info.min[axis] - slack, m_max[axis] = source.info.max[axis] + slack;
        }
        m_bounded = source.info.max[0] > source.info.min[0] && source.info.max[1] > source.info.min[1];
    }

    [[nodiscard]] bool wild(const lidar::LasPoint& p) const noexcept {
        return m_bounded && (p.x < m_min[0] || p.x > m_max[0] || p.y < m_min[1] || p.y > m_max[1] || p.z < m_min[2] || p.z > m_max[2]);
    }

    /// @return false when the point lies beyond what fixed point can hold (about 520,000 voxels from the base)
    bool place(double easting, double northing, double z, VoxelPoint& out) const noexcept {
        return fix(m_frame.x(easting) - m_base.x, out.x) && fix(m_frame.z(northing) - m_base.z, out.z) &&
               fix(m_frame.y(z * m_source.vertical_metres), out.y);
    }

private:
    static bool fix(double voxels, std::int32_t& out) noexcept {
        const double scaled = std::floor(voxels * kFractionOne);
        if (!(std::abs(scaled) < 2147483000.0)) return false;
        out = static_cast<std::int32_t>(scaled);
        return true;
    }
    const SquareSource& m_source;
    const Frame& m_frame;
    Base m_base;
    std::array<double, 3> m_min{}, m_max{};
    bool m_bounded = false;
};

struct Part {
    std::vector<VoxelPoint> points;
    std::uint64_t wild = 0;
};

Part load_range(const SquareSource& source, const Frame& frame, Base base, const ClassTable& classes, lidar::PointRange range) {
    const Placer placer(source, frame, base);
    Part part;
    part.points.reserve(static_cast<std::size_t>(std::min<std::uint64_t>(range.end - range.begin, 4 * kPointsPerRange)));
    std::vector<double> x, y, z;  // only for files in another CRS: transformed all at once
    lidar::read_las_points(source.info, range, [&](const lidar::LasPoint& p) {
        if (p.withheld || classes.meaning[p.classification].role == Role::kDrop) return;
        VoxelPoint out;
        out.source_class = p.classification;
        out.rgb = p.rgb;
        if (placer.wild(p)) {
            ++part.wild;
        } else if (source.transform) {
            x.push_back(p.x), y.push_back(p.y), z.push_back(p.z);
            part.points.push_back(out);
        } else if (placer.place(p.x, p.y, p.z, out)) {
            part.points.push_back(out);
        } else {
            ++part.wild;
        }
    });
    if (source.transform) {
        geo::Transform(*source.info.crs, frame.crs()).apply(x, y);
        std::size_t kept = 0;
        for (std::size_t i = 0; i < x.size(); ++i) {
            VoxelPoint out = part.points[i];
            if (placer.place(x[i], y[i], z[i], out)) part.points[kept++] = out;
            else ++part.wild;
        }
        part.points.resize(kept);
    }
    return part;
}

}  // namespace

std::size_t PatchKeyHash::operator()(const PatchKey& k) const noexcept { return static_cast<std::size_t>(voxel::morton_encode(k.px, 0, k.pz)); }

std::span<const VoxelPoint> Square::points(PatchKey patch) const noexcept {
    const auto found = m_ranges.find(patch);
    if (found == m_ranges.end()) return {};
    return std::span(m_points).subspan(found->second.begin, found->second.end - found->second.begin);
}

std::shared_ptr<const Square> Square::from_points(std::vector<std::vector<VoxelPoint>> parts, std::uint64_t wild_points) {
    auto square = std::make_shared<Square>();
    square->m_wild_points = wild_points;
    const auto patch_of = [](const VoxelPoint& p) { return PatchKey{p.x >> kPatchShift, p.z >> kPatchShift}; };
    // Counting sort by patch: neighbours in a file are mostly of one patch, so the last one is remembered.
    std::unordered_map<PatchKey, std::size_t, PatchKeyHash> index_of;
    std::vector<PatchKey> keys;
    std::vector<std::size_t> counts;
    const auto index = [&](PatchKey key) {
        const auto [at, fresh] = index_of.try_emplace(key, keys.size());
        if (fresh) keys.push_back(key), counts.push_back(0);
        return at->second;
    };
    std::uint16_t brightest = 0;
    PatchKey last{INT32_MAX, INT32_MAX};
    std::size_t last_index = 0, total = 0;
    const auto index_cached = [&](const VoxelPoint& p) {
        const PatchKey key = patch_of(p);
        if (!(key == last)) last = key, last_index = index(key);
        return last_index;
    };
    for (const auto& part : parts) {
        total += part.size();
        for (const VoxelPoint& p : part) {
            ++counts[index_cached(p)];
            for (const std::uint16_t c : p.rgb) brightest = std::max(brightest, c);
        }
    }
    std::vector<std::size_t> next(counts.size());
    std::size_t at = 0;
    for (std::size_t i = 0; i < counts.size(); ++i) {
        square->m_ranges[keys[i]] = {at, at + counts[i]};
        next[i] = at;
        at += counts[i];
    }
    square->m_points.resize(total);
    for (auto& part : parts) {
        for (const VoxelPoint& p : part) square->m_points[next[index_cached(p)]++] = p;
        part = {};
    }
    // The format stores 16 bits a channel, but many writers store 8.
    square->m_has_colour = brightest > 0;
    square->m_colour_shift = brightest > 255 ? 8 : 0;
    return square;
}

std::shared_ptr<const Square> load_square(const SquareSource& source, const Frame& frame, Base base, const ClassTable& classes, int threads) {
    const auto ranges = lidar::split_by_chunk(source.info, kPointsPerRange);
    std::vector<Part> parts(ranges.size());
    thread::parallel_for(ranges.size(), threads, [&](std::size_t i) { parts[i] = load_range(source, frame, base, classes, ranges[i]); });
    std::vector<std::vector<VoxelPoint>> points;
    std::uint64_t wild = 0;
    for (Part& part : parts) points.push_back(std::move(part.points)), wild += part.wild;
    return Square::from_points(std::move(points), wild);
}

}  // namespace terravox::voxelize
