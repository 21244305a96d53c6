#include <algorithm>
#include <array>
#include <random>

#include "common/voxel/box_builder.hpp"
#include "tests/catch.hpp"

using terravox::voxel::ColumnBits;

namespace {

// One flag for each y in [-1, 257).
struct PlainColumn {
    std::array<bool, 258> at{};
    void fill(int y0, int y1) {
        for (int y = std::max(y0, -1); y < std::min(y1, 257); ++y)
            at[static_cast<std::size_t>(y + 1)] = true;
    }
    [[nodiscard]] bool get(int y) const { return at[static_cast<std::size_t>(y + 1)]; }
};

void check_equal(const ColumnBits& bits, const PlainColumn& plain) {
    int wrong = 0;
    for (int y = -1; y < 257; ++y)
        wrong += bits.at(y) != plain.get(y);
    for (int y = 0; y < 256; ++y) {
        wrong += (bits.word(y / 64) >> (y % 64) & 1) != static_cast<unsigned>(plain.get(y));
        wrong += (bits.word_from_above(y / 64) >> (y % 64) & 1) !=
                 static_cast<unsigned>(plain.get(y + 1));
        wrong += (bits.word_from_below(y / 64) >> (y % 64) & 1) !=
                 static_cast<unsigned>(plain.get(y - 1));
    }
    CHECK(wrong == 0);
}

}  // namespace

TEST_CASE("a filled run of a column sets exactly its voxels", "[common][voxel][column]") {
    struct Case {
        const char* name;
        int y0;
        int y1;
    };
    const auto c = GENERATE(values<Case>({
        {"nothing", 5, 5},
        {"a run turned round", 9, 3},
        {"one voxel at the bottom", 0, 1},
        {"one voxel at the top", 255, 256},
        {"one whole word", 64, 128},
        {"across two words", 60, 70},
        {"across all words", 1, 255},
        {"the whole box", 0, 256},
        {"the box and its margins", -1, 257},
        {"far beyond both ends", -100'000, 100'000},
        {"the lower margin alone", -1, 0},
        {"the upper margin alone", 256, 257},
        {"below the margin", -50, -1},
        {"above the margin", 257, 300},
        {"up to the lower margin", -7, 0},
        {"from the last voxel on", 255, 999},
    }));
    DYNAMIC_SECTION(c.name) {
        ColumnBits bits;
        PlainColumn plain;
        bits.fill(c.y0, c.y1);
        plain.fill(c.y0, c.y1);
        check_equal(bits, plain);
    }
}

TEST_CASE("random runs add up in a column", "[common][voxel][column]") {
    const auto seed = GENERATE(range(0u, 200u));
    std::mt19937 random(seed);
    ColumnBits bits;
    PlainColumn plain;
    const auto runs = random() % 12;
    for (unsigned i = 0; i < runs; ++i) {
        const int y0 = static_cast<int>(random() % 280) - 12;
        const int y1 = y0 + static_cast<int>(random() % 80);
        bits.fill(y0, y1);
        plain.fill(y0, y1);
    }
    INFO("seed " << seed);
    check_equal(bits, plain);
}
