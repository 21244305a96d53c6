#include "voxelserver/make/voxelize/columns/point_set.hpp"

#include "tests/catch.hpp"

using namespace terravox;
using namespace terravox::voxelize;

namespace {

SquareSource with_islands(std::vector<grid::ColumnRect> islands) {
    SquareSource out;
    out.islands = std::move(islands);
    return out;
}

/// Two files side by side, and one whose points lie in two places.
const std::vector<SquareSource> kFiles{
    with_islands({{0, 0, 100, 100}}),
    with_islands({{100, 0, 200, 100}}),
    with_islands({{-70, -70, -20, -10}, {5000, 5000, 5200, 5200}}),
};

}  // namespace

TEST_CASE("bounds are half-open, and each part of them counts", "[voxelserver][voxelize][bounds]") {
    const SurveyBounds bounds(kFiles);
    struct Case {
        std::int32_t x;
        std::int32_t z;
        bool inside;
    };
    for (const Case& c :
         {Case{0, 0, true}, Case{99, 99, true}, Case{100, 50, true}, Case{199, 50, true},
          Case{200, 50, false}, Case{-1, 0, false}, Case{50, 100, false}, Case{-70, -70, true},
          Case{-20, -20, false}, Case{5100, 5100, true}, Case{2000, 2000, false}}) {
        INFO(c.x << " " << c.z);
        CHECK(bounds.contains(c.x, c.z) == c.inside);
    }
}

TEST_CASE("a rectangle is surrounded where one part of the bounds holds all of it",
          "[voxelserver][voxelize][bounds]") {
    const SurveyBounds bounds(kFiles);
    CHECK(bounds.surrounds({0, 0, 100, 100}));
    CHECK(bounds.surrounds({10, 20, 30, 40}));
    CHECK_FALSE(bounds.surrounds({0, 0, 101, 100}));
    CHECK_FALSE(bounds.surrounds({90, 0, 110, 10}));  // two files hold it together
    CHECK_FALSE(bounds.surrounds({300, 300, 310, 310}));
    CHECK_FALSE(SurveyBounds(std::span<const SquareSource>{}).surrounds({0, 0, 1, 1}));
}

TEST_CASE("the window around a patch has what contains() says of each column",
          "[voxelserver][voxelize][bounds]") {
    const SurveyBounds bounds(kFiles);
    for (const grid::PatchKey middle :
         {grid::PatchKey{0, 0}, grid::PatchKey{1, 1}, grid::PatchKey{-2, -1},
          grid::PatchKey{78, 79}, grid::PatchKey{40, 40}}) {
        INFO(middle.px << " " << middle.pz);
        const auto inside = bounds.around(middle);
        int wrong = 0;
        Grid<char, Window::kMargin>::each([&](int x, int z) {
            const bool wanted = bounds.contains(middle.x0() + x, middle.z0() + z);
            wrong += inside.at(x, z) == (wanted ? 1 : 0) ? 0 : 1;
        });
        CHECK(wrong == 0);
    }
}
