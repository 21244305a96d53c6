#include "voxelserver/data/sunlight/light_removal.hpp"

#include <algorithm>
#include <random>

#include "tests/catch.hpp"

using namespace terravox::sunlight;

TEST_CASE("sums over squares are those of their cells", "[voxelserver][sunlight]") {
    const int reach = GENERATE(1, 3, 4, 6);
    constexpr int kWidth = 23;
    constexpr int kHeight = 19;
    CAPTURE(reach);
    std::mt19937 random(7);
    std::vector<BrightCell> cells(static_cast<std::size_t>(kWidth) * kHeight);
    for (BrightCell& cell : cells) {
        cell.as = static_cast<BrightCell::As>(random() % 3);
        // Whole numbers, so that sums are exact in any order.
        cell.light = static_cast<float>(random() % 100);
    }
    const BrightnessAround around(kWidth, reach, cells);
    for (int z = reach; z < kHeight - reach; ++z)
        for (int x = reach; x < kWidth - reach; ++x) {
            BrightnessAround::Sums wanted;
            for (int dz = -reach; dz <= reach; ++dz)
                for (int dx = -reach; dx <= reach; ++dx) {
                    const BrightCell& cell =
                        cells[static_cast<std::size_t>((z + dz) * kWidth + x + dx)];
                    if (cell.as == BrightCell::As::kLit) {
                        wanted.lit += cell.light;
                        wanted.brightest_lit = std::max(wanted.brightest_lit, cell.light);
                        ++wanted.lit_count;
                    } else if (cell.as == BrightCell::As::kShadow) {
                        wanted.shadow += cell.light;
                        ++wanted.shadow_count;
                    }
                }
            const BrightnessAround::Sums found = around.at(x, z);
            CHECK(found.lit == wanted.lit);
            CHECK(found.brightest_lit == wanted.brightest_lit);
            CHECK(found.lit_count == wanted.lit_count);
            CHECK(found.shadow == wanted.shadow);
            CHECK(found.shadow_count == wanted.shadow_count);
        }
}
