#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"

#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "voxelserver/make/voxelize/points/sources.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

TEST_CASE("the fingerprint of all boxes is another for another frame, water, bed and lowest box",
          "[voxelserver][voxelize][fingerprint]") {
    const geo::Crs crs = geo::Crs::from_text(kCrs);
    Sources sources{.frame = grid::Frame(crs, 1, 0, 0),
                    .files = {},
                    .bounds = {},
                    .typical_heights = {},
                    .named_squares = {},
                    .known_before = {},
                    .known = {}};
    const ClassTable classes;
    const Settings settings;
    int cell_voxels = 4;
    const auto fingerprint = [&] {
        return fingerprint_everywhere(sources, classes, settings, cell_voxels);
    };
    const voxel::Fingerprint before = fingerprint();
    sources.highest_y = 7;
    sources.lowest_y = 3;
    CHECK(fingerprint() == before);
    SECTION("the size of a voxel") {
        sources.frame = grid::Frame(crs, 0.5, 0, 0);
    }
    SECTION("points of water") {
        sources.has_water_class = true;
    }
    SECTION("from where the terrain is solid") {
        sources.floor_y = -1;
    }
    SECTION("the lowest box") {
        sources.lowest_y = -1;
    }
    SECTION("cells of water") {
        cell_voxels = 8;
    }
    CHECK_FALSE(fingerprint() == before);
}
