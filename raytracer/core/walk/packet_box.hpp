// The rays of a packet in one box, each in a cell of its own; included once for each target of
// Highway, see packet_steps.cpp.
#if defined(TERRAVOX_PACKET_BOX_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRAVOX_PACKET_BOX_HPP
#undef TERRAVOX_PACKET_BOX_HPP
#else
#define TERRAVOX_PACKET_BOX_HPP
#endif

#include "raytracer/core/walk/packet_lanes.hpp"
#include "raytracer/core/walk/packet_steps.hpp"

HWY_BEFORE_NAMESPACE();
namespace terravox::walk::HWY_NAMESPACE {

/// Rays of a vector. Axes on which they go down are mirrored, v -> -1 - v, so that all go up: a
/// crossing is the same number to the last bit, and the bits of a child's coordinates are flipped.
struct Way {
    VD origin[3], direction[3], inverse[3];
    /// First voxels beyond the box, or from which on nothing is in the way; encoded as by
    /// bits_from().
    VD end[3];
    /// `origin`, reduced so that rounding a position to the nearest whole number gives its voxel or
    /// the one before.
    VD estimate[3];
};

/// Where the rays are (voxels encoded as by bits_from()) and what is there.
struct Walkers {
    VU voxel[3];
    VD axis;                           ///< axis crossed last; -1: none in this box
    VU node, node_detail, node_first;  ///< of the cell of 16 x 16 x 16 voxels; node == 0: empty
    VU node_size;  ///< where it is empty: number of voxels that may be leapt over, less 1
    /// Index of the cell of 4 x 4 x 4 voxels (0: hidden rock) and its mask (0: empty).
    VU brick;
    VU solid;
    VU size;  ///< of the empty cell, in voxels, less 1
    WordLanes going;
    WordLanes stopped;
    WordLanes new_node, new_brick;  ///< lanes that have entered another node or brick
};

/// Fields of root cells.
struct Root {
    VU mask;
    VU detail;
    VU first;
};

/// The tree of the box that all rays are in, and how its children lie for the packet's directions.
struct SharedTree {
    const std::uint64_t* cells;
    Root roots;  ///< from the bottom up, repeated to fill the vector
    VU flip;     ///< of the bits of a child
    VU flip_root;

    /// Field 0 to 2 of the cells at the given indices.
    [[nodiscard]] HWY_INLINE VU field(VU index, int of) const {
        return hn::GatherIndex(
            du, cells + of,
            hn::BitCast(hn::RebindToSigned<Words>(), hn::Add(index, hn::Add(index, index))));
    }
    [[nodiscard]] HWY_INLINE VU root_number(VU y) const {
        return hn::Xor(hn::And(hn::ShiftRight<6>(y), word(3)), flip_root);
    }
    [[nodiscard]] HWY_INLINE Root root(VU number) const {
        const auto lane = hn::IndicesFromVec(du, number);
        return {hn::TableLookupLanes(roots.mask, lane), hn::TableLookupLanes(roots.detail, lane),
                hn::TableLookupLanes(roots.first, lane)};
    }
};

HWY_INLINE VU root_field(const voxel::TreeCell* cells,
                         std::uint64_t (*field)(const voxel::TreeCell&)) {
    alignas(64) std::uint64_t of[8];
    for (int i = 0; i < kWidth; ++i)
        of[i] = field(cells[i % voxel::Box::kRootCount]);
    return hn::Load(du, of);
}

HWY_INLINE SharedTree to_tree(const voxel::TreeCell* cells, const bool (&forward)[3]) {
    SharedTree out;
    out.cells = reinterpret_cast<const std::uint64_t*>(cells);
    out.roots.mask = root_field(cells, [](const voxel::TreeCell& c) { return c.mask; });
    out.roots.detail = root_field(cells, [](const voxel::TreeCell& c) { return c.detail; });
    out.roots.first =
        root_field(cells, [](const voxel::TreeCell& c) -> std::uint64_t { return c.first; });
    out.flip = word((forward[0] ? 0 : 3) | (forward[2] ? 0 : 12) | (forward[1] ? 0 : 48));
    out.flip_root = word(forward[1] ? 0 : 3);
    return out;
}

/// child_bit() of voxel >> shift.
template <int kShift, class Tree>
HWY_INLINE VU find_child(const Walkers& w, const Tree& tree) {
    VU z = w.voxel[2];
    VU y = w.voxel[1];
    if constexpr (kShift == 0) {
        z = hn::ShiftLeft<2>(z);
        y = hn::ShiftLeft<4>(y);
    }
    if constexpr (kShift == 2)
        y = hn::ShiftLeft<2>(y);
    if constexpr (kShift == 4)
        z = hn::ShiftRight<2>(z);
    const VU x = kShift == 0 ? w.voxel[0] : hn::ShiftRight<kShift>(w.voxel[0]);
    return hn::Xor(hn::Or3(hn::And(x, word(3)), hn::And(z, word(12)), hn::And(y, word(48))),
                   tree.flip);
}

/// As voxel_leap_shift(): whether the eight children around are empty.
HWY_INLINE WordLanes eight_empty(VU mask, VU bit) {
    return hn::Eq(
        hn::And(hn::Shr(mask, hn::And(bit, word(~std::uint64_t{1 | 4 | 16}))), word(0x330033)),
        hn::Zero(du));
}

/// Index of a child of a cell.
HWY_INLINE VU compute_index(VU detail, VU first, VU one) {
    return hn::Add(first, hn::PopulationCount(hn::And(detail, hn::Sub(one, word(1)))));
}

constexpr std::uint64_t kAll = ~std::uint64_t{0};

template <class Tree>
HWY_INLINE void find_node(Walkers& w, const Tree& tree) {
    const auto [mask, detail, first] = tree.root(tree.root_number(w.voxel[1]));
    const VU bit = find_child<4>(w, tree);
    const VU one = hn::Shl(word(1), bit);
    const WordLanes there = hn::And(w.new_node, hn::TestBit(mask, one));
    const WordLanes fine = hn::And(there, hn::TestBit(detail, one));
    const VU index = hn::IfThenElseZero(fine, compute_index(detail, first, one));
    const VU empty = choose(hn::Eq(mask, hn::Zero(du)), word(63),
                            choose(eight_empty(mask, bit), word(31), word(15)));
    // Hidden rock is treated as if all its bricks were set.
    const VU node = choose(fine, tree.field(index, 0), hn::IfThenElseZero(there, word(kAll)));
    w.node = choose(w.new_node, node, w.node);
    w.node_detail =
        choose(w.new_node, hn::IfThenElseZero(fine, tree.field(index, 1)), w.node_detail);
    w.node_first =
        choose(w.new_node, hn::And(tree.field(index, 2), word(0xffff'ffff)), w.node_first);
    w.node_size = choose(w.new_node, hn::IfThenZeroElse(there, empty), w.node_size);
}

template <class Tree>
HWY_INLINE void find_brick(Walkers& w, const Tree& tree) {
    const VU bit = find_child<2>(w, tree);
    const VU one = hn::Shl(word(1), bit);
    const WordLanes there = hn::And(w.going, hn::TestBit(w.node, one));
    const WordLanes fine = hn::And(there, hn::TestBit(w.node_detail, one));
    const VU index = hn::IfThenElseZero(fine, compute_index(w.node_detail, w.node_first, one));
    w.brick = choose(w.going, index, w.brick);
    w.solid = choose(fine, tree.field(index, 0), hn::IfThenElseZero(there, word(kAll)));
    w.size = hn::Or(choose(eight_empty(w.node, bit), word(7), word(3)), w.node_size);
}

/// Stops the rays that are in a solid voxel, and finds how far the others may leap.
template <class Tree>
HWY_INLINE void look(Walkers& w, const Tree& tree) {
    if (!hn::AllFalse(du, w.new_node))
        find_node(w, tree);
    if (!hn::AllFalse(du, w.new_brick))
        find_brick(w, tree);
    const VU bit = find_child<0>(w, tree);
    const WordLanes here = hn::And(w.going, hn::TestBit(w.solid, hn::Shl(word(1), bit)));
    w.stopped = hn::Or(w.stopped, here);
    w.going = hn::AndNot(here, w.going);
    const VU in_brick = hn::IfThenElseZero(eight_empty(w.solid, bit), word(1));
    w.size = choose(hn::Ne(w.solid, hn::Zero(du)), in_brick, w.size);
}

HWY_INLINE Lanes is_before(const Walkers& w, const Way& way, int axis) {
    return hn::Lt(hn::BitCast(d, w.voxel[axis]), way.end[axis]);
}

/// Moves the rays that are going out of their cells, or one voxel onwards, as RayState::leap does.
HWY_INLINE void leap_out(Walkers& w, const Way& way) {
    VU last[3], plane[3];
    VD out[3];
    for (int a = 0; a < 3; ++a) {
        last[a] = hn::Or(w.voxel[a], w.size);
        plane[a] = hn::Add(last[a], word(1));
        out[a] = hn::Mul(hn::Sub(number_from(plane[a]), way.origin[a]), way.inverse[a]);
    }
    const Lanes x_first = hn::And(hn::Le(out[0], out[1]), hn::Le(out[0], out[2]));
    const Lanes y_first = hn::AndNot(x_first, hn::Le(out[1], out[2]));
    const Lanes z_first = hn::Not(hn::Or(x_first, y_first));
    const Lanes first[3] = {x_first, y_first, z_first};
    const VD at = hn::Min(out[0], hn::Min(out[1], out[2]));
    VU moved[3];
    for (int a = 0; a < 3; ++a) {
        // RayState::position_after: `low` or the next voxel, depending on whether the plane between
        // them has been crossed.
        const VU low = bits_from(hn::Add(way.estimate[a], hn::Mul(way.direction[a], at)));
        const VU high = hn::Add(low, word(1));
        const VD c = hn::Mul(hn::Sub(number_from(high), way.origin[a]), way.inverse[a]);
        const Lanes crossed = a == 0   ? hn::Le(c, at)
                              : a == 1 ? hn::Or(hn::Lt(c, at), hn::And(z_first, hn::Eq(c, at)))
                                       : hn::Lt(c, at);
        const VD beside = hn::BitCast(d, choose(words(crossed), high, low));
        const VD within =
            hn::Max(hn::BitCast(d, w.voxel[a]), hn::Min(beside, hn::BitCast(d, last[a])));
        const VU to = choose(words(first[a]), plane[a], hn::BitCast(du, within));
        moved[a] = hn::Xor(to, w.voxel[a]);
        w.voxel[a] = choose(w.going, to, w.voxel[a]);
    }
    const VD axis = choose(x_first, hn::Zero(d), choose(y_first, hn::Set(d, 1.0), hn::Set(d, 2.0)));
    w.axis = choose(doubles(w.going), axis, w.axis);
    const VU any = hn::Or3(moved[0], moved[1], moved[2]);
    w.going = hn::And(hn::And(w.going, words(is_before(w, way, 0))),
                      hn::And(words(is_before(w, way, 1)), words(is_before(w, way, 2))));
    w.new_node = hn::And(w.going, hn::Ne(hn::And(any, word(kAll << 4)), hn::Zero(du)));
    w.new_brick = hn::And(w.going, hn::Ne(hn::And(any, word(kAll << 2)), hn::Zero(du)));
}

HWY_INLINE void start(const RayPacket& p, int first, std::uint32_t lanes, const PacketCell& block,
                      Way& way, Walkers& w) {
    Lanes in = to_lanes(lanes, first);
    for (int a = 0; a < 3; ++a) {
        const VD sign = hn::Set(d, p.forward[a] ? 1.0 : -1.0);
        const VD shift = hn::Set(d, p.forward[a] ? 0.0 : -1.0);
        way.origin[a] = hn::Mul(hn::Load(d, p.origin[a] + first), sign);
        way.direction[a] = hn::Mul(hn::Load(d, p.direction[a] + first), sign);
        way.inverse[a] = hn::Mul(hn::Load(d, p.inverse[a] + first), sign);
        way.estimate[a] = hn::Sub(way.origin[a], hn::Set(d, 0.5 + RayLanes::kSlack_voxel));
        const VD v = hn::Add(hn::Mul(hn::Load(d, p.voxel[a] + first), sign), shift);
        const VD low = hn::Set(d, p.forward[a] ? block.low[a] : -1 - block.high[a]);
        VD end = hn::Set(d, p.forward[a] ? block.high[a] + 1 : -block.low[a]);
        if (p.free_axis == a) {
            const VD scale = hn::Mul(sign, hn::Set(d, det::exp2_int(-p.level)));
            end = hn::Min(end, hn::Ceil(hn::Mul(hn::Load(d, p.free_from + first), scale)));
        }
        in = hn::And(in, hn::And(hn::Ge(v, low), hn::Lt(v, end)));
        w.voxel[a] = bits_from(v);
        way.end[a] = hn::BitCast(d, bits_from(end));
    }
    w.going = words(in);
    w.new_node = w.new_brick = w.going;
    w.stopped = hn::Ne(word(0), word(0));
    w.axis = hn::Set(d, -1.0);
    w.node = w.node_detail = w.node_first = w.node_size = w.brick = w.solid = w.size = hn::Zero(du);
}

HWY_INLINE void finish(RayPacket& p, int first, const Way& way, const Walkers& w) {
    VD t = hn::Load(d, p.t + first);
    for (int a = 0; a < 3; ++a) {
        const VD v = number_from(w.voxel[a]);
        const Lanes through = hn::Eq(w.axis, hn::Set(d, static_cast<double>(a)));
        t = choose(through, hn::Mul(hn::Sub(v, way.origin[a]), way.inverse[a]), t);
        hn::Store(p.forward[a] ? v : hn::Sub(hn::Set(d, -1.0), v), d, p.voxel[a] + first);
    }
    const Lanes moved = hn::Ge(w.axis, hn::Zero(d));
    hn::Store(t, d, p.t + first);
    hn::Store(choose(moved, w.axis, hn::Load(d, p.axis + first)), d, p.axis + first);
    hn::Store(w.brick, du, p.brick + first);
}

// The instructions of a step depend on each other: two interleaved vectors hide the latency.
constexpr int kTogether = 2;

std::uint32_t box(RayPacket& p, const voxel::TreeCell* cells, const PacketCell& block,
                  std::uint32_t lanes, std::uint64_t& steps) noexcept {
    const SharedTree tree = to_tree(cells, p.forward);
    std::uint32_t stopped = 0;
    for (int first = 0; first < p.count; first += kWidth * kTogether) {
        Way way[kTogether];
        Walkers w[kTogether];
#pragma GCC unroll 2
        for (int j = 0; j < kTogether; ++j)
            start(p, first + j * kWidth, lanes, block, way[j], w[j]);
        while (true) {
            ++steps;
            WordLanes going = hn::Ne(word(0), word(0));
#pragma GCC unroll 2
            for (int j = 0; j < kTogether; ++j)
                look(w[j], tree), going = hn::Or(going, w[j].going);
            if (hn::AllFalse(du, going))
                break;
#pragma GCC unroll 2
            for (int j = 0; j < kTogether; ++j)
                leap_out(w[j], way[j]);
        }
#pragma GCC unroll 2
        for (int j = 0; j < kTogether; ++j) {
            finish(p, first + j * kWidth, way[j], w[j]);
            stopped |= to_bits(doubles(w[j].stopped), first + j * kWidth);
        }
    }
    return stopped;
}

}  // namespace terravox::walk::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
