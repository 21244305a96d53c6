#include "common/voxel/box.hpp"

#include <random>

#include "tests/catch.hpp"

using namespace terravox::voxel;

namespace {

// Bit by bit, as the definition says.
std::uint64_t by_definition(std::int32_t x, std::int32_t y, std::int32_t z) {
    std::uint64_t code = 0;
    for (unsigned bit = 0; bit < 21; ++bit) {
        code |= std::uint64_t{static_cast<std::uint32_t>(x) >> bit & 1} << (3 * bit);
        code |= std::uint64_t{static_cast<std::uint32_t>(y) >> bit & 1} << (3 * bit + 1);
        code |= std::uint64_t{static_cast<std::uint32_t>(z) >> bit & 1} << (3 * bit + 2);
    }
    return code;
}

void check_all_ways(std::int32_t x, std::int32_t y, std::int32_t z) {
    INFO("(" << x << ", " << y << ", " << z << ")");
    const std::uint64_t code = morton_encode(x, y, z);
    CHECK(code == by_definition(x, y, z));
    CHECK(code == morton_encode_portable(x, y, z));
    const MortonCoord back = morton_decode(code);
    CHECK((back.x == x && back.y == y && back.z == z));
}

constexpr std::int32_t kLowest = -(1 << 20);
constexpr std::int32_t kHighest = (1 << 20) - 1;

}  // namespace

TEST_CASE("a Morton code interleaves x, y, z from the lowest bit on", "[common][voxel][morton]") {
    struct Case {
        const char* name;
        std::int32_t x;
        std::int32_t y;
        std::int32_t z;
        std::uint64_t code;
    };
    const auto c = GENERATE(values<Case>({
        {"origin", 0, 0, 0, 0},
        {"x is the lowest bit", 1, 0, 0, 1},
        {"y is the second", 0, 1, 0, 2},
        {"z is the third", 0, 0, 1, 4},
        {"the eight voxels of a cell come first", 1, 1, 1, 7},
        {"then the next triple", 2, 0, 0, 8},
        {"y of the next triple", 0, 2, 0, 16},
        {"a mixed one", 5, 3, 6, 0b101'110'011},
        {"minus one everywhere is all 63 bits", -1, -1, -1, 0x7fffffffffffffff},
        {"the lowest coordinate is its top bit", kLowest, 0, 0, std::uint64_t{1} << 60},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK(morton_encode(c.x, c.y, c.z) == c.code);
        CHECK(morton_encode_portable(c.x, c.y, c.z) == c.code);
    }
}

TEST_CASE("corners of the range go to a Morton code and back", "[common][voxel][morton]") {
    for (const std::int32_t x : {kLowest, -1, 0, 1, kHighest})
        for (const std::int32_t y : {kLowest, -1, 0, 1, kHighest})
            for (const std::int32_t z : {kLowest, -1, 0, 1, kHighest})
                check_all_ways(x, y, z);
}

TEST_CASE("random coordinates go to a Morton code and back, with and without BMI2",
          "[common][voxel][morton]") {
    std::mt19937 random(20240621);
    std::uniform_int_distribution<std::int32_t> any(kLowest, kHighest);
    for (int i = 0; i < 2000; ++i)
        check_all_ways(any(random), any(random), any(random));
}

TEST_CASE("coordinates beyond the range are taken modulo 2^21, the same either way",
          "[common][voxel][morton]") {
    std::mt19937 random(7);
    for (int i = 0; i < 2000; ++i) {
        const auto x = static_cast<std::int32_t>(random());
        const auto y = static_cast<std::int32_t>(random());
        const auto z = static_cast<std::int32_t>(random());
        INFO("(" << x << ", " << y << ", " << z << ")");
        CHECK(morton_encode(x, y, z) == by_definition(x, y, z));
        CHECK(morton_encode_portable(x, y, z) == by_definition(x, y, z));
    }
}

TEST_CASE("an aligned cube of 2^n boxes is one run of Morton codes", "[common][voxel][morton]") {
    const auto n = GENERATE(1, 2, 3, 4);
    const std::int32_t side = 1 << n;
    const std::int32_t x0 = -3 * side;
    const std::int32_t y0 = 5 * side;
    const std::int32_t z0 = -7 * side;
    const std::uint64_t first = morton_encode(x0, y0, z0);
    const std::uint64_t count = std::uint64_t{1} << (3 * n);
    int outside = 0;
    for (std::int32_t z = z0; z < z0 + side; ++z)
        for (std::int32_t y = y0; y < y0 + side; ++y)
            for (std::int32_t x = x0; x < x0 + side; ++x)
                outside += morton_encode(x, y, z) - first >= count;
    CHECK(outside == 0);
}
