#include "raytracer/farm/render/passes/passes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <tuple>

namespace terravox::render {
namespace {

/// A conservative estimate of what a camera may see of the world. The blur of a lens is ignored:
/// what it adds is loaded when a ray needs it.
class Sight {
public:
    Sight(const scene::Camera& camera, int width_px, int height_px)
        : m_eye(camera.position()), m_forward(camera.forward()), m_projection(camera.projection()) {
        if (m_projection == scene::Projection::kFisheye)
            m_half_angle = camera.half_angle_rad();
        if (m_projection == scene::Projection::kPerspective)
            add_sides_from_eye(camera, width_px, height_px);
        if (m_projection == scene::Projection::kOrthographic)
            add_parallel_sides(camera);
    }
    /// Whether a block may be in sight.
    [[nodiscard]] bool may_see(const core::Vec3& low, const core::Vec3& high) const noexcept {
        if (m_projection == scene::Projection::kPanorama)
            return true;
        if (m_projection == scene::Projection::kFisheye)
            return in_cone(low, high);
        return std::all_of(m_sides.begin(), m_sides.end(), [&](const Side& side) {
            const core::Vec3& n = side.inwards;
            const core::Vec3 farthest{n.x > 0 ? high.x : low.x, n.y > 0 ? high.y : low.y,
                                      n.z > 0 ? high.z : low.z};
            return core::dot(n, farthest - side.point) >= 0;
        });
    }
    /// Grows with the distance of a block from where rays start.
    [[nodiscard]] double order(const core::Vec3& low, const core::Vec3& high) const noexcept {
        if (m_projection == scene::Projection::kOrthographic) {
            const core::Vec3 nearest{m_forward.x > 0 ? low.x : high.x,
                                     m_forward.y > 0 ? low.y : high.y,
                                     m_forward.z > 0 ? low.z : high.z};
            return core::dot(m_forward, nearest - m_eye);
        }
        const core::Vec3 nearest{std::clamp(m_eye.x, low.x, high.x),
                                 std::clamp(m_eye.y, low.y, high.y),
                                 std::clamp(m_eye.z, low.z, high.z)};
        return core::dot(nearest - m_eye, nearest - m_eye);
    }

private:
    struct Side {
        core::Vec3 point;
        core::Vec3 inwards;
    };
    // Planes through the eye and two corners of the picture.
    void add_sides_from_eye(const scene::Camera& camera, double w, double h) {
        const std::array<core::Vec3, 4> corners = {
            camera.ray(0, 0).direction, camera.ray(w, 0).direction, camera.ray(w, h).direction,
            camera.ray(0, h).direction};
        for (std::size_t i = 0; i < 4; ++i) {
            const core::Vec3 n = core::cross(corners[i], corners[(i + 1) % 4]);
            m_sides[i] = {m_eye, core::dot(n, m_forward) < 0 ? -n : n};
        }
    }
    void add_parallel_sides(const scene::Camera& camera) {
        const scene::Camera::Basis b = camera.basis();
        const core::Vec3 right = b.right * (b.width / b.height);
        m_sides = {{{m_eye - right, right},
                    {m_eye + right, -right},
                    {m_eye - b.up, b.up},
                    {m_eye + b.up, -b.up}}};
    }
    // By the sphere around the block: it reaches asin(radius / distance) beyond its middle.
    [[nodiscard]] bool in_cone(const core::Vec3& low, const core::Vec3& high) const noexcept {
        const core::Vec3 middle = (low + high) * 0.5;
        const core::Vec3 to = middle - m_eye;
        const double radius = core::length(high - middle);
        const double distance = core::length(to);
        if (distance <= radius)
            return true;
        return std::acos(std::clamp(core::dot(to, m_forward) / distance, -1.0, 1.0)) <=
               m_half_angle + std::asin(radius / distance) + 1e-9;
    }

    core::Vec3 m_eye;
    core::Vec3 m_forward;
    scene::Projection m_projection;
    double m_half_angle = 0;
    std::array<Side, 4> m_sides;
};

struct Column {
    double order;
    int level;
    std::int32_t bx;
    std::int32_t bz;
    /// Orders a priority queue nearest first; the order of equal ones does not depend on the order
    /// of insertion.
    friend bool operator<(const Column& a, const Column& b) noexcept {
        return std::tie(b.order, b.level, b.bx, b.bz) < std::tie(a.order, a.level, a.bx, a.bz);
    }
};

}  // namespace

std::vector<voxel::BoxKey> boxes_in_sight(const scene::Camera& camera, int width_px, int height_px,
                                          const walk::LevelCut& cut, std::size_t max) {
    std::vector<voxel::BoxKey> out;
    if (cut.bounds().empty())
        return out;
    const Sight sight(camera, width_px, height_px);
    const voxel::VoxelBounds& all = cut.entry_bounds();
    std::priority_queue<Column> queue;
    const auto consider = [&](int level, std::int32_t bx, std::int32_t bz) {
        const double side =
            static_cast<double>(std::int64_t{1} << (walk::LevelCut::kSideBits + level));
        // Voxels of the column's level, and of finer ones, stick out of the world by less than
        // this.
        const double voxel = static_cast<double>(std::int64_t{1} << level);
        const core::Vec3 low{std::max(bx * side, static_cast<double>(all.min[0])),
                             std::floor(cut.bounds().min[1] / voxel) * voxel,
                             std::max(bz * side, static_cast<double>(all.min[2]))};
        const core::Vec3 high{std::min((bx + 1) * side, static_cast<double>(all.max[0])),
                              std::ceil(cut.bounds().max[1] / voxel) * voxel,
                              std::min((bz + 1) * side, static_cast<double>(all.max[2]))};
        if (low.x >= high.x || low.z >= high.z || !sight.may_see(low, high))
            return;
        queue.push({sight.order(low, high), level, bx, bz});
    };
    // From a level of which a few columns are the world, however large it is.
    int level = cut.coarsest();
    voxel::BoxRange top = voxel::boxes_over(cut.bounds(), level);
    constexpr std::int64_t kFew = 4;
    while (level < voxel::kMaxLevel &&
           (top.max.bx - top.min.bx > kFew || top.max.bz - top.min.bz > kFew))
        top = voxel::boxes_over(cut.bounds(), ++level);
    for (std::int32_t bx = top.min.bx; bx < top.max.bx; ++bx)
        for (std::int32_t bz = top.min.bz; bz < top.max.bz; ++bz)
            consider(level, bx, bz);
    while (!queue.empty() && out.size() < max) {
        const Column c = queue.top();
        queue.pop();
        if (cut.far_enough(c.level, c.bx, c.bz)) {
            const voxel::BoxRange range = voxel::boxes_over(cut.bounds(), c.level);
            for (std::int32_t by = range.min.by; by < range.max.by && out.size() < max; ++by)
                out.push_back({c.level, c.bx, by, c.bz});
            continue;
        }
        for (int half = 0; half < 4; ++half)
            consider(c.level - 1, c.bx * 2 + (half & 1), c.bz * 2 + (half >> 1));
    }
    return out;
}

}  // namespace terravox::render
