#include "raytracer/world/boxes_in_sight.hpp"

#include <algorithm>
#include <array>
#include <queue>
#include <tuple>

namespace terravox {
namespace {

/// The four planes through the eye that bound the picture; normals point inwards.
class Frustum {
public:
    Frustum(const Camera& camera, int width_px, int height_px) : m_eye(camera.position()) {
        const double w = width_px, h = height_px;
        const std::array<Vec3, 4> corners = {camera.ray(0, 0).direction, camera.ray(w, 0).direction, camera.ray(w, h).direction, camera.ray(0, h).direction};
        for (std::size_t i = 0; i < 4; ++i) {
            const Vec3 n = cross(corners[i], corners[(i + 1) % 4]);
            m_normals[i] = dot(n, camera.forward()) < 0 ? -n : n;
        }
    }
    /// Whether a block may be in sight: not wholly outside one plane.
    [[nodiscard]] bool may_see(const Vec3& low, const Vec3& high) const noexcept {
        return std::all_of(m_normals.begin(), m_normals.end(), [&](const Vec3& n) {
            const Vec3 farthest{n.x > 0 ? high.x : low.x, n.y > 0 ? high.y : low.y, n.z > 0 ? high.z : low.z};
            return dot(n, farthest - m_eye) >= 0;
        });
    }

private:
    Vec3 m_eye;
    std::array<Vec3, 4> m_normals;
};

struct Column {
    double distance2;
    int level;
    std::int32_t bx, bz;
    /// The nearest first out of a priority queue; of equals an order that does not depend on how they came.
    friend bool operator<(const Column& a, const Column& b) noexcept {
        return std::tie(b.distance2, b.level, b.bx, b.bz) < std::tie(a.distance2, a.level, a.bx, a.bz);
    }
};

}  // namespace

std::vector<voxel::BoxKey> boxes_in_sight(const Camera& camera, int width_px, int height_px, const LevelCut& cut, std::size_t most) {
    std::vector<voxel::BoxKey> out;
    if (cut.bounds().empty()) return out;
    const Frustum frustum(camera, width_px, height_px);
    const Vec3 eye = camera.position();
    const voxel::VoxelBounds& all = cut.entry_bounds();
    std::priority_queue<Column> queue;
    const auto consider = [&](int level, std::int32_t bx, std::int32_t bz) {
        const double side = static_cast<double>(std::int64_t{1} << (LevelCut::kSideBits + level));
        const Vec3 low{std::max(bx * side, static_cast<double>(all.min[0])), static_cast<double>(all.min[1]), std::max(bz * side, static_cast<double>(all.min[2]))};
        const Vec3 high{std::min((bx + 1) * side, static_cast<double>(all.max[0])), static_cast<double>(all.max[1]), std::min((bz + 1) * side, static_cast<double>(all.max[2]))};
        if (low.x >= high.x || low.z >= high.z || !frustum.may_see(low, high)) return;
        const Vec3 nearest{std::clamp(eye.x, low.x, high.x), std::clamp(eye.y, low.y, high.y), std::clamp(eye.z, low.z, high.z)};
        queue.push({dot(nearest - eye, nearest - eye), level, bx, bz});
    };
    // From a level of which a few columns are the world, however large it is.
    int level = cut.coarsest();
    voxel::BoxRange top = voxel::boxes_over(cut.bounds(), level);
    constexpr std::int64_t kFew = 4;
    while (level < voxel::kMaxLevel && (top.max.bx - top.min.bx > kFew || top.max.bz - top.min.bz > kFew)) top = voxel::boxes_over(cut.bounds(), ++level);
    for (std::int32_t bx = top.min.bx; bx < top.max.bx; ++bx)
        for (std::int32_t bz = top.min.bz; bz < top.max.bz; ++bz) consider(level, bx, bz);
    while (!queue.empty() && out.size() < most) {
        const Column c = queue.top();
        queue.pop();
        if (cut.far_enough(c.level, c.bx, c.bz)) {
            const voxel::BoxRange range = voxel::boxes_over(cut.bounds(), c.level);
            for (std::int32_t by = range.min.by; by < range.max.by && out.size() < most; ++by) out.push_back({c.level, c.bx, by, c.bz});
            continue;
        }
        for (int half = 0; half < 4; ++half) consider(c.level - 1, c.bx * 2 + (half & 1), c.bz * 2 + (half >> 1));
    }
    return out;
}

}  // namespace terravox
