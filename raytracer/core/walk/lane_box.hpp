// Rays of a vector, each in a box of its own; included once for each target of Highway, see
// packet_steps.cpp.
#if defined(TERRAVOX_LANE_BOX_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRAVOX_LANE_BOX_HPP
#undef TERRAVOX_LANE_BOX_HPP
#else
#define TERRAVOX_LANE_BOX_HPP
#endif

#include "raytracer/core/walk/packet_box.hpp"
#include "raytracer/core/walk/ray_packet.hpp"

HWY_BEFORE_NAMESPACE();
namespace terravox::walk::HWY_NAMESPACE {

/// The trees of as many boxes as there are lanes.
struct LaneTrees {
    VU cells;  ///< addresses in words
    VU flip;
    const RayLanes& lanes;
    int first;

    [[nodiscard]] HWY_INLINE VU field(VU index, int of) const {
        const VU at = hn::Add(cells, hn::Add(index, hn::Add(hn::Add(index, index),
                                                            word(static_cast<std::uint64_t>(of)))));
        return hn::GatherIndex(du, static_cast<const std::uint64_t*>(nullptr),
                               hn::BitCast(hn::RebindToSigned<Words>(), at));
    }
    // Blends are much cheaper than gathers.
    [[nodiscard]] HWY_INLINE VU root_field(int of, WordLanes odd, WordLanes upper) const {
        const auto& fields = lanes.root[of];
        const auto at = [&](int number) { return hn::Load(du, fields[number] + first); };
        return choose(upper, choose(odd, at(3), at(2)), choose(odd, at(1), at(0)));
    }
    [[nodiscard]] HWY_INLINE Root root(VU number) const {
        const WordLanes odd = hn::TestBit(number, word(1));
        const WordLanes upper = hn::TestBit(number, word(2));
        return {root_field(0, odd, upper), root_field(1, odd, upper), root_field(2, odd, upper)};
    }
    [[nodiscard]] static HWY_INLINE VU root_number(VU y) {
        return hn::And(hn::ShiftRight<6>(y), word(3));
    }
};

HWY_INLINE WordLanes to_word_lanes(std::uint32_t bits, int first) {
    return words(to_lanes(bits, first));
}
HWY_INLINE VU bits_at(const double (&field)[RayLanes::kLanes], int first) {
    return hn::BitCast(du, hn::Load(d, field + first));
}

HWY_INLINE LaneTrees list_trees(const RayLanes& lanes, int first) {
    return {hn::Load(du, lanes.cells + first), hn::Load(du, lanes.flip + first), lanes, first};
}

HWY_INLINE void load(const RayLanes& lanes, int first, Way& way, Walkers& w) {
    for (int a = 0; a < 3; ++a) {
        way.origin[a] = hn::Load(d, lanes.origin[a] + first);
        way.direction[a] = hn::Load(d, lanes.direction[a] + first);
        way.inverse[a] = hn::Load(d, lanes.inverse[a] + first);
        way.estimate[a] = hn::Load(d, lanes.estimate[a] + first);
        way.end[a] = hn::Load(d, lanes.end[a] + first);
        w.voxel[a] = bits_at(lanes.voxel[a], first);
    }
    w.axis = hn::Load(d, lanes.axis + first);
    w.node = hn::Load(du, lanes.node + first);
    w.node_detail = hn::Load(du, lanes.node_detail + first);
    w.node_first = hn::Load(du, lanes.node_first + first);
    w.node_size = hn::Load(du, lanes.node_size + first);
    w.brick = hn::Load(du, lanes.brick + first);
    w.solid = hn::Load(du, lanes.solid + first);
    w.size = hn::Load(du, lanes.size + first);
    w.going = to_word_lanes(lanes.going, first);
    w.new_node = w.new_brick = to_word_lanes(lanes.fresh, first);
    w.stopped = hn::Ne(word(0), word(0));
}

HWY_INLINE void store(const Walkers& w, int first, RayLanes& lanes) {
    for (int a = 0; a < 3; ++a)
        hn::Store(hn::BitCast(d, w.voxel[a]), d, lanes.voxel[a] + first);
    hn::Store(w.axis, d, lanes.axis + first);
    hn::Store(w.node, du, lanes.node + first);
    hn::Store(w.node_detail, du, lanes.node_detail + first);
    hn::Store(w.node_first, du, lanes.node_first + first);
    hn::Store(w.node_size, du, lanes.node_size + first);
    hn::Store(w.brick, du, lanes.brick + first);
    hn::Store(w.solid, du, lanes.solid + first);
    hn::Store(w.size, du, lanes.size + first);
}

void advance(RayLanes& lanes, std::uint64_t& steps) noexcept {
    std::uint32_t going_on = 0;
    std::uint32_t stopped = 0;
    for (int first = 0; first < RayLanes::kLanes; first += kWidth * kTogether) {
        const LaneTrees trees[kTogether] = {list_trees(lanes, first),
                                            list_trees(lanes, first + kWidth)};
        Way way[kTogether];
        Walkers w[kTogether];
        std::size_t started = 0;
#pragma GCC unroll 2
        for (int j = 0; j < kTogether; ++j)
            load(lanes, first + j * kWidth, way[j], w[j]), started += hn::CountTrue(du, w[j].going);
        if (started == 0)
            continue;
        // Number of lanes still going at or below which the loop ends: a quarter of them needs
        // attention.
        const std::size_t enough = started - (started + 3) / 4;
        while (true) {
            ++steps;
            std::size_t going = 0;
#pragma GCC unroll 2
            for (int j = 0; j < kTogether; ++j)
                look(w[j], trees[j]), going += hn::CountTrue(du, w[j].going);
            if (going <= enough)
                break;
#pragma GCC unroll 2
            for (int j = 0; j < kTogether; ++j)
                leap_out(w[j], way[j]);
        }
#pragma GCC unroll 2
        for (int j = 0; j < kTogether; ++j) {
            store(w[j], first + j * kWidth, lanes);
            stopped |= to_bits(doubles(w[j].stopped), first + j * kWidth);
            going_on |= to_bits(doubles(w[j].going), first + j * kWidth);
        }
    }
    lanes.going = going_on;
    lanes.stopped = stopped;
    lanes.fresh = 0;
}

}  // namespace terravox::walk::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
