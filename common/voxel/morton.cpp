#include "common/voxel/box.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace terravox::voxel {
namespace {

constexpr std::uint64_t kCoordMask = (std::uint64_t{1} << 21) - 1;
constexpr std::uint64_t kEveryThird = 0x1249249249249249;

// Spreads the low 21 bits to every third bit, halving the number of gaps with each step.
std::uint64_t spread(std::uint64_t v) noexcept {
    v &= kCoordMask;
    v = (v | v << 32) & 0x001f00000000ffff;
    v = (v | v << 16) & 0x001f0000ff0000ff;
    v = (v | v << 8) & 0x100f00f00f00f00f;
    v = (v | v << 4) & 0x10c30c30c30c30c3;
    v = (v | v << 2) & kEveryThird;
    return v;
}

std::int32_t gather(std::uint64_t v) noexcept {
    v &= kEveryThird;
    v = (v | v >> 2) & 0x10c30c30c30c30c3;
    v = (v | v >> 4) & 0x100f00f00f00f00f;
    v = (v | v >> 8) & 0x001f0000ff0000ff;
    v = (v | v >> 16) & 0x001f00000000ffff;
    v = (v | v >> 32) & kCoordMask;
    // Sign extension from 21 bits.
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(v) << 11) >> 11;
}

#if defined(__x86_64__)
__attribute__((target("bmi2"))) std::uint64_t encode_bmi2(std::int32_t x, std::int32_t y,
                                                          std::int32_t z) noexcept {
    return _pdep_u64(static_cast<std::uint32_t>(x), kEveryThird) |
           _pdep_u64(static_cast<std::uint32_t>(y), kEveryThird << 1) |
           _pdep_u64(static_cast<std::uint32_t>(z), kEveryThird << 2);
}
const bool kHasBmi2 = [] {
    __builtin_cpu_init();
    return __builtin_cpu_supports("bmi2") != 0;
}();
#endif

}  // namespace

std::uint64_t morton_encode_portable(std::int32_t x, std::int32_t y, std::int32_t z) noexcept {
    return spread(static_cast<std::uint32_t>(x)) | spread(static_cast<std::uint32_t>(y)) << 1 |
           spread(static_cast<std::uint32_t>(z)) << 2;
}

std::uint64_t morton_encode(std::int32_t x, std::int32_t y, std::int32_t z) noexcept {
#if defined(__x86_64__)
    if (kHasBmi2)
        return encode_bmi2(x, y, z);
#endif
    return morton_encode_portable(x, y, z);
}

MortonCoord morton_decode(std::uint64_t code) noexcept {
    return {gather(code), gather(code >> 1), gather(code >> 2)};
}

}  // namespace terravox::voxel
