#include "raytracer/core/walk/packet_steps.hpp"

#include <cstdlib>
#include <cstring>

// The later AVX-512 counts the bits of whole vectors. SSSE3 brings nothing here that its neighbours
// have not. The vectors of 64-bit ARM are not used: NEON's hold two numbers, too few (steps()), and
// those of SVE have no size that a compiler knows.
#define HWY_WANT_AVX3_DL
#define HWY_DISABLED_TARGETS HWY_SSSE3
#ifdef __aarch64__
#define HWY_COMPILE_ONLY_EMU128
#endif
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "raytracer/core/walk/packet_steps.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "raytracer/core/walk/lane_box.hpp"
#include "raytracer/core/walk/packet_box.hpp"
#include "raytracer/core/walk/packet_lanes.hpp"

HWY_BEFORE_NAMESPACE();
namespace terravox::walk::HWY_NAMESPACE {

std::uint32_t inside(const RayPacket& p, const PacketCell& cell, std::uint32_t active) noexcept {
    std::uint32_t out = 0;
    for (int first = 0; first < p.count; first += kWidth) {
        Lanes in = to_lanes(active, first);
        for (int a = 0; a < 3; ++a) {
            const VD v = hn::Load(d, p.voxel[a] + first);
            in = hn::And(in, hn::And(hn::Ge(v, hn::Set(d, cell.low[a])),
                                     hn::Le(v, hn::Set(d, cell.high[a]))));
        }
        out |= to_bits(in, first);
    }
    return out;
}

/// RayState::position_after for lanes whose estimate is off by at most one.
HWY_INLINE VD position_after(VD origin, VD direction, VD inverse, bool forward, VD at,
                             Lanes earlier_axis, VD low, VD high) {
    const VD one = hn::Set(d, 1.0);
    const auto crossed = [&](VD plane) {
        const VD c = hn::Mul(hn::Sub(plane, origin), inverse);
        return hn::Or(hn::Lt(c, at), hn::And(hn::Eq(c, at), earlier_axis));
    };
    const VD p = hn::Min(hn::Max(hn::Floor(hn::Add(origin, hn::Mul(direction, at))), low), high);
    const VD up = hn::Add(p, one);
    Lanes more;
    Lanes less;
    if (forward) {
        more = hn::And(hn::Lt(p, high), crossed(up));
        less = hn::AndNot(crossed(p), hn::Gt(p, low));
    } else {
        less = hn::And(hn::Gt(p, low), crossed(p));
        more = hn::AndNot(crossed(up), hn::Lt(p, high));
    }
    return hn::Sub(hn::Add(p, hn::IfThenElseZero(more, one)), hn::IfThenElseZero(less, one));
}

// Operation by operation what Camera::ray, RayState and BeamStart::place do for one ray. In one
// function, since the vectors would not stay in registers between two.
std::uint32_t primary(RayPacket& p, const PrimaryLanes& wanted) noexcept {
    const scene::Camera::Basis& c = wanted.camera;
    const VD one = hn::Set(d, 1.0);
    const VD two = hn::Set(d, 2.0);
    const VD height = hn::Set(d, c.height);
    const VD width = hn::Set(d, c.width);
    std::uint32_t out = 0;
    p.level = 0;
    p.count = RayPacket::kLanes;
    for (int a = 0; a < 3; ++a)
        if (!(std::abs(c.position[a]) < RayPacket::kMaxOrigin))
            return 0;
    for (int first = 0; first < RayPacket::kLanes; first += kWidth) {
        const VD px = hn::Load(d, wanted.px + first);
        const VD py = hn::Load(d, wanted.py + first);
        const VD u = hn::Div(hn::Sub(hn::Mul(two, px), width), height);
        const VD v = hn::Div(hn::Sub(height, hn::Mul(two, py)), height);
        VD direction[3], inverse[3];
        for (int a = 0; a < 3; ++a) {
            const VD aside = hn::Add(hn::Set(d, c.forward[a]), hn::Mul(hn::Set(d, c.right[a]), u));
            direction[a] = hn::Add(aside, hn::Mul(hn::Set(d, c.up[a]), v));
        }
        const VD squares = hn::Add(
            hn::Add(hn::Mul(direction[0], direction[0]), hn::Mul(direction[1], direction[1])),
            hn::Mul(direction[2], direction[2]));
        const VD scale = hn::Div(one, hn::Sqrt(squares));
        Lanes fit = hn::Eq(one, one);
        for (int a = 0; a < 3; ++a) {
            direction[a] = hn::Mul(direction[a], scale);
            inverse[a] = hn::Div(one, direction[a]);
            if (first == 0)
                p.forward[a] = hn::GetLane(direction[a]) > 0;
            fit = hn::And(fit, hn::Lt(hn::Abs(inverse[a]), hn::Set(d, RayPacket::kMaxInverse)));
            const Lanes forward = hn::Gt(direction[a], hn::Zero(d));
            fit = hn::And(fit, p.forward[a] ? forward : hn::Not(forward));
            hn::Store(direction[a], d, p.direction[a] + first);
            hn::Store(inverse[a], d, p.inverse[a] + first);
        }
        const VD plane = hn::Set(d, wanted.plane);
        const VD eye = hn::Set(d, c.position[wanted.axis]);
        const VD at = hn::Mul(hn::Sub(plane, eye), inverse[wanted.axis]);
        for (int a = 0; a < 3; ++a) {
            const VD origin = hn::Set(d, c.position[a]);
            const VD low = hn::Set(d, wanted.low[a]);
            const VD high = hn::Set(d, wanted.high[a]);
            VD voxel = p.forward[a] ? plane : hn::Sub(plane, one);
            if (a != wanted.axis) {
                const Lanes earlier = a < wanted.axis ? hn::Eq(one, one) : hn::Lt(one, one);
                voxel = position_after(origin, direction[a], inverse[a], p.forward[a], at, earlier,
                                       hn::Sub(low, two), hn::Add(high, two));
            }
            fit = hn::And(fit, hn::And(hn::Ge(voxel, low), hn::Le(voxel, high)));
            hn::Store(origin, d, p.origin[a] + first);
            hn::Store(voxel, d, p.voxel[a] + first);
        }
        fit = hn::And(fit, hn::Gt(at, hn::Zero(d)));
        hn::Store(at, d, p.t + first);
        hn::Store(hn::Set(d, wanted.axis), d, p.axis + first);
        out |= to_bits(fit, first);
    }
    return out;
}

void leap(RayPacket& p, const PacketCell& cell, std::uint32_t lanes) noexcept {
    const VD one = hn::Set(d, 1.0);
    for (int first = 0; first < p.count; first += kWidth) {
        if ((lanes >> first & ((1u << kWidth) - 1)) == 0)
            continue;
        const Lanes on = to_lanes(lanes, first);
        VD origin[3], direction[3], inverse[3], voxel[3], out[3];
        for (int a = 0; a < 3; ++a) {
            origin[a] = hn::Load(d, p.origin[a] + first);
            direction[a] = hn::Load(d, p.direction[a] + first);
            inverse[a] = hn::Load(d, p.inverse[a] + first);
            voxel[a] = hn::Load(d, p.voxel[a] + first);
            out[a] = hn::Mul(
                hn::Sub(hn::Set(d, p.forward[a] ? cell.high[a] + 1 : cell.low[a]), origin[a]),
                inverse[a]);
        }
        const Lanes x_first = hn::And(hn::Le(out[0], out[1]), hn::Le(out[0], out[2]));
        const Lanes y_first = hn::AndNot(x_first, hn::Le(out[1], out[2]));
        const Lanes z_first = hn::Not(hn::Or(x_first, y_first));
        const Lanes chosen[3] = {x_first, y_first, z_first};
        const VD at = hn::Min(out[0], hn::Min(out[1], out[2]));
        // Which axes come before the chosen one: x before y and z, y before z.
        const Lanes earlier[3] = {hn::Not(x_first), z_first, hn::Lt(one, one)};
        for (int a = 0; a < 3; ++a) {
            const VD low = hn::Set(d, cell.low[a]);
            const VD high = hn::Set(d, cell.high[a]);
            const VD beside =
                position_after(origin[a], direction[a], inverse[a], p.forward[a], at, earlier[a],
                               p.forward[a] ? voxel[a] : low, p.forward[a] ? high : voxel[a]);
            const VD beyond = hn::Set(d, p.forward[a] ? cell.high[a] + 1 : cell.low[a] - 1);
            hn::Store(choose(on, choose(chosen[a], beyond, beside), voxel[a]), d,
                      p.voxel[a] + first);
        }
        hn::Store(choose(on, at, hn::Load(d, p.t + first)), d, p.t + first);
        const VD axis = choose(x_first, hn::Zero(d), choose(y_first, one, hn::Set(d, 2.0)));
        hn::Store(choose(on, axis, hn::Load(d, p.axis + first)), d, p.axis + first);
    }
}

const PacketSteps* steps() {
    static constexpr PacketSteps out{primary, inside, leap, box, advance};
    return kWidth >= 4 ? &out : nullptr;
}

}  // namespace terravox::walk::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terravox::walk {
namespace {

HWY_EXPORT(steps);

const PacketSteps* choose_steps() noexcept {
    const char* wanted = std::getenv("TERRAVOX_SIMD");
    if (wanted != nullptr && std::strcmp(wanted, "none") == 0)
        return nullptr;
    if (wanted != nullptr && std::strcmp(wanted, "avx2") == 0)
        hwy::DisableTargets(HWY_AVX3 | HWY_AVX3_DL);
    return HWY_DYNAMIC_DISPATCH(steps)();
}

}  // namespace

PrimaryLanes primary_lanes(const scene::Camera& camera, const BeamStart& start,
                           const LevelCut& cut) noexcept {
    PrimaryLanes out;
    out.camera = camera.basis();
    out.axis = start.axis;
    out.plane = start.plane;
    const voxel::VoxelBounds& bounds = cut.entry_bounds();
    for (std::size_t a = 0; a < 3; ++a) {
        out.low[a] = bounds.min[a];
        out.high[a] = bounds.max[a] - 1;
    }
    return out;
}

const PacketSteps* packet_steps() noexcept {
    static const PacketSteps* const out = choose_steps();
    return out;
}

}  // namespace terravox::walk
#endif
