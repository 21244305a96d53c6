#include "voxelserver/data/water/deepening.hpp"

#include <algorithm>
#include <cmath>

#include "common/util/error.hpp"

namespace terravox::water {
namespace {

constexpr int kLongestReach = 1024;  // squares fit well into 32 bits

// Pass over columns: distance to the nearest dry column of the same x, at most `far`.
std::vector<std::int32_t> vertical(const std::vector<std::uint8_t>& mask, int width, int height,
                                   std::int32_t far) {
    const auto w = static_cast<std::size_t>(width);
    const auto h = static_cast<std::size_t>(height);
    std::vector<std::int32_t> out(mask.size());
    for (std::size_t z = 0; z < h; ++z)
        for (std::size_t x = 0; x < w; ++x)
            out[z * w + x] =
                mask[z * w + x] == 0 ? 0 : std::min(far, (z == 0 ? far : out[(z - 1) * w + x]) + 1);
    for (std::size_t z = h - 1; z-- > 0;)
        for (std::size_t x = 0; x < w; ++x)
            out[z * w + x] = std::min(out[z * w + x], out[(z + 1) * w + x] + 1);
    return out;
}

// Pass over one row: for each x the minimum of (x - i)^2 + g[i]^2, by the lower envelope of these
// parabolas.
class RowEnvelope {
public:
    explicit RowEnvelope(int width)
        : m_centre(static_cast<std::size_t>(width)), m_from(static_cast<std::size_t>(width)) {}

    void run(const std::int32_t* g, int width, std::int32_t reach, float* out) {
        std::ptrdiff_t top = 0;
        at(m_centre, 0) = 0;
        at(m_from, 0) = 0;
        for (std::int32_t u = 1; u < width; ++u) {
            while (top >= 0 &&
                   value(g, at(m_from, top), at(m_centre, top)) > value(g, at(m_from, top), u))
                --top;
            if (top < 0) {
                top = 0;
                at(m_centre, 0) = u;
                at(m_from, 0) = 0;
                continue;
            }
            // The first x at which u's parabola is lower.
            const std::int64_t i = at(m_centre, top);
            const std::int64_t gi = g[i];
            const std::int64_t gu = g[u];
            const std::int64_t above = std::int64_t{u} * u - i * i + gu * gu - gi * gi;
            const std::int64_t below = 2 * (u - i);
            const std::int64_t from =
                (above >= 0 ? above / below : -((-above + below - 1) / below)) + 1;
            if (from < width) {
                ++top;
                at(m_centre, top) = u;
                at(m_from, top) = static_cast<std::int32_t>(std::max<std::int64_t>(from, 0));
            }
        }
        const std::int64_t most = std::int64_t{reach} * reach;
        for (std::int32_t u = width - 1; u >= 0; --u) {
            const std::int64_t squared = value(g, u, at(m_centre, top));
            out[u] = squared >= most ? static_cast<float>(reach)
                                     : static_cast<float>(std::sqrt(static_cast<double>(squared)));
            if (u == at(m_from, top) && top > 0)
                --top;
        }
    }

private:
    static std::int32_t& at(std::vector<std::int32_t>& v, std::ptrdiff_t i) {
        return v[static_cast<std::size_t>(i)];
    }
    static std::int64_t value(const std::int32_t* g, std::int32_t x, std::int32_t i) {
        return std::int64_t{x - i} * (x - i) + std::int64_t{g[i]} * g[i];
    }
    std::vector<std::int32_t> m_centre;
    std::vector<std::int32_t> m_from;
};

void check_shape(const Deepening& s, double voxel_m) {
    if (!(s.slope >= 0 && s.min_depth_m >= 0 && s.max_depth_m >= s.min_depth_m && voxel_m > 0))
        throw util::Error(
            "deepen water: slope {:f}, depth {:f} to {:f} m, voxel {:f} m; allowed: slope and "
            "depths 0 or more, least depth no more than the greatest, voxel above 0",
            s.slope, s.min_depth_m, s.max_depth_m, voxel_m);
}

}  // namespace

std::vector<float> shore_distance(const std::vector<std::uint8_t>& mask, int width, int height,
                                  int reach_voxels) {
    if (width < 0 || height < 0 ||
        mask.size() != static_cast<std::size_t>(width) * static_cast<std::size_t>(height))
        throw util::Error("deepen water: mask of {} columns; expected {} x {}", mask.size(), width,
                          height);
    if (reach_voxels < 1 || reach_voxels > kLongestReach)
        throw util::Error("deepen water: reach of {} voxels; allowed: 1 to {}", reach_voxels,
                          kLongestReach);
    std::vector<float> out(mask.size());
    if (mask.empty())
        return out;
    const std::vector<std::int32_t> g = vertical(mask, width, height, reach_voxels);
    RowEnvelope envelope(width);
    for (std::size_t row = 0; row < mask.size(); row += static_cast<std::size_t>(width))
        envelope.run(&g[row], width, reach_voxels, &out[row]);
    return out;
}

float depth_m(float distance_voxels, double voxel_m, const Deepening& shape) noexcept {
    if (!(distance_voxels > 0))
        return 0;
    return static_cast<float>(
        std::clamp(shape.slope * (static_cast<double>(distance_voxels) - 0.5) * voxel_m,
                   shape.min_depth_m, shape.max_depth_m));
}

std::vector<float> depths_m(const std::vector<std::uint8_t>& mask, int width, int height,
                            double voxel_m, const Deepening& shape) {
    check_shape(shape, voxel_m);
    std::vector<float> out = shore_distance(mask, width, height, shape.reach_voxels);
    for (float& v : out)
        v = depth_m(v, voxel_m, shape);
    return out;
}

}  // namespace terravox::water
