// Vector types for the steps of packets; included once for each target of Highway, see
// packet_steps.cpp.
#if defined(TERRAVOX_PACKET_LANES_HPP) == defined(HWY_TARGET_TOGGLE)
#ifdef TERRAVOX_PACKET_LANES_HPP
#undef TERRAVOX_PACKET_LANES_HPP
#else
#define TERRAVOX_PACKET_LANES_HPP
#endif

#include <hwy/highway.h>

#include "raytracer/core/walk/ray_packet.hpp"

HWY_BEFORE_NAMESPACE();
namespace terravox::walk::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

// Eight lanes of 64 bits, or four.
using Doubles = hn::CappedTag<double, 8>;
using Words = hn::RebindToUnsigned<Doubles>;
using VD = hn::Vec<Doubles>;
using VU = hn::Vec<Words>;
using Lanes = hn::Mask<Doubles>;
using WordLanes = hn::Mask<Words>;
constexpr Doubles d;
constexpr Words du;
constexpr int kWidth = static_cast<int>(hn::MaxLanes(d));
static_assert(RayPacket::kLanes % kWidth == 0);

HWY_INLINE Lanes to_lanes(std::uint32_t bits, int first) {
    const std::uint8_t byte = static_cast<std::uint8_t>(bits >> first);
    alignas(8) const std::uint8_t loaded[8] = {byte};
    return hn::LoadMaskBits(d, loaded);
}
HWY_INLINE std::uint32_t to_bits(Lanes lanes, int first) {
    alignas(8) std::uint8_t stored[8] = {};
    hn::StoreMaskBits(d, lanes, stored);
    return static_cast<std::uint32_t>(stored[0]) << first;
}
HWY_INLINE VD choose(Lanes yes, VD a, VD b) {
    return hn::IfThenElse(yes, a, b);
}
HWY_INLINE VU choose(WordLanes yes, VU a, VU b) {
    return hn::IfThenElse(yes, a, b);
}
HWY_INLINE VU word(std::uint64_t v) {
    return hn::Set(du, v);
}
HWY_INLINE WordLanes words(Lanes m) {
    return hn::RebindMask(du, m);
}
HWY_INLINE Lanes doubles(WordLanes m) {
    return hn::RebindMask(d, m);
}

constexpr double kWhole = RayLanes::kWholeNumber;
HWY_INLINE VU bits_from(VD whole) {
    return hn::BitCast(du, hn::Add(whole, hn::Set(d, kWhole)));
}
HWY_INLINE VD number_from(VU bits) {
    return hn::Sub(hn::BitCast(d, bits), hn::Set(d, kWhole));
}

}  // namespace terravox::walk::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
