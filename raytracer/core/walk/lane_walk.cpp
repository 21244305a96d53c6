#include "raytracer/core/walk/lane_walk.hpp"

#include <algorithm>

#include "raytracer/core/base/material_groups.hpp"
#include "raytracer/core/walk/ray_packet.hpp"

namespace terravox::walk {
namespace {

constexpr std::int32_t kAllAir = std::numeric_limits<std::int32_t>::min();

int to_shift(int size) noexcept {
    return LevelCut::kSideBits + 2 * size;
}

}  // namespace

Skyline::Skyline(BlockReader& reader, const LevelCut& cut) : m_reader(reader), m_cut(cut) {
    for (auto& table : m_squares)
        table.resize(std::size_t{1} << 2 * kSlotBits);
}

int Skyline::open_above(const core::RayState& ray) {
    int open = 0;
    for (int size = 0; size < kSizes && ray.voxel[1] >= lowest_free(size, ray); ++size)
        open = to_shift(size);
    return open;
}

Skyline::Square& Skyline::slot(int size, std::int32_t x, std::int32_t z) noexcept {
    constexpr std::int32_t kMask = (1 << kSlotBits) - 1;
    const std::int32_t place = (x & kMask) | (z & kMask) << kSlotBits;
    return m_squares[static_cast<std::size_t>(size)][static_cast<std::size_t>(place)];
}

// What is unknown is looked up again now and then: boxes arrive while the picture is made.
std::int32_t Skyline::lowest_free(int size, const core::RayState& ray) {
    constexpr int kLookInterval = 32;
    const std::int32_t x = ray.voxel[0] >> to_shift(size);
    const std::int32_t z = ray.voxel[2] >> to_shift(size);
    Square& square = slot(size, x, z);
    if (square.x != x || square.z != z || square.level != ray.level)
        square = {x, z, kUnknown, ray.level, 0};
    if (square.free_from == kUnknown && square.lookups++ % kLookInterval == 0)
        square.free_from = size == 0 ? look_down(square) : highest_of_parts(size, square);
    return square.free_from;
}

std::int32_t Skyline::look_down(const Square& column) {
    const voxel::VoxelBounds& bounds = m_cut.bounds(column.level);
    for (std::int32_t by = (bounds.max[1] - 1) >> 8; by >= bounds.min[1] >> 8; --by) {
        const blocks::Block* block = m_reader.get({column.level, column.x, by, column.z});
        if (block == nullptr || block->hole)
            return kUnknown;
        if (block->box && block->box->top() > 0)
            return by * voxel::kBoxSizeY + block->box->top();
    }
    return kAllAir;
}

// Only of what rays have asked for before: looking at columns far from every ray would take room
// in memory from boxes that are needed.
std::int32_t Skyline::highest_of_parts(int size, const Square& square) noexcept {
    const voxel::VoxelBounds& bounds = m_cut.bounds(square.level);
    const int shift = to_shift(size - 1);
    std::int32_t highest = kAllAir;
    for (int part = 0; part < 16; ++part) {
        const std::int32_t x = square.x * 4 + (part & 3);
        const std::int32_t z = square.z * 4 + (part >> 2);
        const bool outside = x < bounds.min[0] >> shift || x > (bounds.max[0] - 1) >> shift ||
                             z < bounds.min[2] >> shift || z > (bounds.max[2] - 1) >> shift;
        if (outside)
            continue;
        const Square& known = slot(size - 1, x, z);
        if (known.x != x || known.z != z || known.level != square.level ||
            known.free_from == kUnknown)
            return kUnknown;
        highest = std::max(highest, known.free_from);
    }
    return highest;
}

namespace {

using voxel::child_bit;
using voxel::TreeCell;

/// log2 of voxels: taller than nearly all worlds, so that a ray does not stop on its way up.
constexpr int kTall = 14;
/// Cells of idle lanes: the steps read the cells of all lanes.
constexpr TreeCell kNothing;

std::uint64_t to_address(const TreeCell* cell) noexcept {
    return reinterpret_cast<std::uintptr_t>(cell) / sizeof(std::uint64_t);
}

double bits_of_whole(double v) noexcept {
    return v + RayLanes::kWholeNumber;
}
double whole_of_bits(double bits) noexcept {
    return bits - RayLanes::kWholeNumber;
}

/// A plane that the ray reaches after t_max, in voxels of its level.
double plane_after(const core::RayState& ray, int axis, double t_max) noexcept {
    constexpr double kRoom_voxels = 2;
    constexpr double kFarAway = 1e9;
    const double at = ray.origin[axis] + ray.direction[axis] * t_max;
    return std::clamp(std::floor(ray.forward[axis] ? at + kRoom_voxels : at - kRoom_voxels),
                      -kFarAway, kFarAway);
}

/// Releases the held boxes on every exit.
struct Holding {
    explicit Holding(BlockReader& of) : reader(of) { reader.hold(); }
    ~Holding() { reader.release(); }
    Holding(const Holding&) = delete;
    Holding& operator=(const Holding&) = delete;
    BlockReader& reader;
};

}  // namespace

void LaneWalk::trace(std::span<const LaneRay> rays) {
    const Holding holding(m_reader);
    for (int lane = 0; lane < RayLanes::kLanes; ++lane)
        fill(lane, rays);
    while (m_lanes.going != 0) {
        m_steps.advance(m_lanes, m_counts.steps);
        if (m_reader.holds_much())
            let_boxes_go();
        for (int lane = 0; lane < RayLanes::kLanes; ++lane) {
            if ((m_lanes.going >> lane & 1) != 0)
                continue;
            const LaneRay*& ray = m_rays[static_cast<std::size_t>(lane)];
            if (ray != nullptr) {
                const bool stopped = (m_lanes.stopped >> lane & 1) != 0;
                if (stopped)
                    stop(lane);
                else
                    update(lane);
                if (stopped || !enter(lane))
                    ray = nullptr;
            }
            if (ray == nullptr)
                fill(lane, rays);
        }
    }
}

// Releases all boxes; rays on their way request theirs again.
void LaneWalk::let_boxes_go() {
    const std::uint32_t going = std::exchange(m_lanes.going, 0);
    const std::uint32_t stopped = std::exchange(m_lanes.stopped, 0);
    for (int lane = 0; lane < RayLanes::kLanes; ++lane) {
        if ((stopped >> lane & 1) != 0)
            stop(lane);
        else if ((going >> lane & 1) != 0)
            update(lane);
    }
    m_reader.release();
    m_reader.hold();
    for (int lane = 0; lane < RayLanes::kLanes; ++lane) {
        m_lanes.cells[lane] = to_address(&kNothing);
        if ((stopped >> lane & 1) != 0 || ((going >> lane & 1) != 0 && !enter(lane)))
            m_rays[static_cast<std::size_t>(lane)] = nullptr;
    }
}

// Loads the next ray that has some distance to go.
void LaneWalk::fill(int lane, std::span<const LaneRay>& rays) {
    const LaneRay*& ray = m_rays[static_cast<std::size_t>(lane)];
    for (ray = nullptr; ray == nullptr && !rays.empty(); rays = rays.subspan(1)) {
        if (!RayPacket::accepts(*rays.front().state))
            continue;
        ray = &rays.front();
        if (!enter(lane))
            ray = nullptr;
    }
    if (ray == nullptr)
        m_lanes.cells[lane] = to_address(&kNothing);
}

// As RayWalk::walk between boxes. Returns false if the ray has ended, or RayWalk has to continue.
bool LaneWalk::enter(int lane) {
    const LaneRay& of = *m_rays[static_cast<std::size_t>(lane)];
    core::RayState& ray = *of.state;
    while (ray.t <= of.t_max) {
        int level = ray.level;
        while ((level = m_cut.level_at(ray.voxel[0] << ray.level, ray.voxel[2] << ray.level,
                                       level)) != ray.level)
            ray.change_level(level);
        const voxel::VoxelBounds& bounds = m_cut.bounds(level);
        for (int a = 0; a < 3; ++a) {
            const auto i = static_cast<std::size_t>(a);
            if (ray.forward[a] ? ray.voxel[a] >= bounds.max[i] : ray.voxel[a] < bounds.min[i])
                return *of.end = WalkEnd::kMiss, false;
        }
        if (const int open = ray.forward[1] ? m_skyline.open_above(ray) : 0; open > 0) {
            ++m_counts.steps;
            ray.leap(open, kTall, open);
            continue;
        }
        const blocks::Block* block =
            m_reader.get({level, ray.voxel[0] >> 6, ray.voxel[1] >> 8, ray.voxel[2] >> 6});
        if (block == nullptr || block->hole)
            return false;
        if (block->box) {
            load(lane, *block->box);
            return true;
        }
        ++m_counts.steps;
        ray.leap(6, 8, 6);
    }
    *of.end = WalkEnd::kMiss;
    return false;
}

void LaneWalk::load(int lane, const voxel::Box& box) {
    const LaneRay& of = *m_rays[static_cast<std::size_t>(lane)];
    const core::RayState& ray = *of.state;
    constexpr int kShift[3] = {6, 8, 6};
    for (int a = 0; a < 3; ++a) {
        const bool forward = ray.forward[a];
        const double sign = forward ? 1 : -1;
        const std::int32_t low = ray.voxel[a] >> kShift[a] << kShift[a];
        const std::int32_t high = low + (1 << kShift[a]);
        double end = forward ? high : -low;
        if (of.t_max < core::kFar)
            end = std::min(
                end, forward ? plane_after(ray, a, of.t_max) : -plane_after(ray, a, of.t_max));
        m_lanes.origin[a][lane] = ray.origin[a] * sign;
        m_lanes.direction[a][lane] = ray.direction[a] * sign;
        m_lanes.inverse[a][lane] = ray.inverse[a] * sign;
        m_lanes.estimate[a][lane] = ray.origin[a] * sign - (0.5 + RayLanes::kSlack_voxel);
        m_lanes.end[a][lane] = bits_of_whole(end);
        m_lanes.voxel[a][lane] = bits_of_whole(forward ? ray.voxel[a] : -1.0 - ray.voxel[a]);
    }
    m_lanes.cells[lane] = to_address(box.cells().data());
    m_lanes.flip[lane] = static_cast<std::uint64_t>(
        (ray.forward[0] ? 0 : 3) | (ray.forward[2] ? 0 : 12) | (ray.forward[1] ? 0 : 48));
    for (int i = 0; i < RayLanes::kRoots; ++i) {
        // Mirrored, -1 - y: the bits are all turned over, so the first root is met last.
        const TreeCell& root =
            box.cells()[static_cast<std::size_t>(ray.forward[1] ? i : RayLanes::kRoots - 1 - i)];
        m_lanes.root[0][i][lane] = root.mask;
        m_lanes.root[1][i][lane] = root.detail;
        m_lanes.root[2][i][lane] = root.first;
    }
    m_lanes.axis[lane] = -1;
    m_lanes.going |= 1u << lane;
    m_lanes.fresh |= 1u << lane;
    m_boxes[static_cast<std::size_t>(lane)] = &box;
}

// Copies the lane's position to its ray.
void LaneWalk::update(int lane) noexcept {
    core::RayState& ray = *m_rays[static_cast<std::size_t>(lane)]->state;
    if (m_lanes.axis[lane] < 0)
        return;
    for (int a = 0; a < 3; ++a) {
        const auto v = static_cast<std::int32_t>(whole_of_bits(m_lanes.voxel[a][lane]));
        ray.voxel[a] = ray.forward[a] ? v : -1 - v;
    }
    const int axis = static_cast<int>(m_lanes.axis[lane]);
    ray.t = ray.crossing(axis, ray.voxel[axis] + (ray.forward[axis] ? 0.0 : 1.0));
    ray.face = core::to_face(axis, !ray.forward[axis]);
}

// In a solid voxel: the ray has ended, or RayWalk continues.
void LaneWalk::stop(int lane) {
    update(lane);
    const LaneRay& of = *m_rays[static_cast<std::size_t>(lane)];
    const core::RayState& ray = *of.state;
    if (of.hit != nullptr || m_thin == ThinThings::kPass) {
        const std::uint64_t index = m_lanes.brick[lane];
        const voxel::Box& box = *m_boxes[static_cast<std::size_t>(lane)];
        const TreeCell& brick = box.cells()[index];
        const int bit = child_bit(ray.voxel[0], ray.voxel[1], ray.voxel[2]);
        if (index == 0 || (brick.detail >> bit & 1) == 0)
            return;
        const voxel::VoxelAttr& attr = box.attrs()[brick.compute_index(bit)];
        if (attr.material == voxel::Material::kAir)
            // Only possible with an invalid box of an untrusted server: nothing stops at it.
            return;
        if (of.hit == nullptr && core::is_thin(attr.material))
            return;
        if (of.hit != nullptr)
            *of.hit = {ray.t,    {ray.voxel[0], ray.voxel[1], ray.voxel[2]},
                       ray.face, ray.level,
                       false,    attr};
    }
    *of.end = ray.t <= of.t_max ? WalkEnd::kHit : WalkEnd::kMiss;
}

}  // namespace terravox::walk
