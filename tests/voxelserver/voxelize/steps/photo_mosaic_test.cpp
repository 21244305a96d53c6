#include "voxelserver/voxelize/steps/photo_mosaic.hpp"

#include <algorithm>
#include <cmath>

#include "tests/catch.hpp"

using namespace terravox;
using voxelize::PhotoMosaic;

namespace {

/// Three by three images of 100 x 80 columns; the first is the north-western one.
PhotoMosaic three_by_three() {
    std::vector<grid::ColumnRect> images;
    for (std::int32_t z = 0; z < 3; ++z)
        for (std::int32_t x = 0; x < 3; ++x)
            images.push_back({100 * x - 50, 80 * z, 100 * x + 50, 80 * z + 80});
    return PhotoMosaic(std::move(images));
}

}  // namespace

TEST_CASE("over equal images side by side the weights sum up to one",
          "[voxelserver][voxelize][photo-mosaic]") {
    const PhotoMosaic mosaic = three_by_three();
    for (std::int32_t z = 40; z <= 200; z += 7)
        for (std::int32_t x = 0; x <= 200; x += 9) {
            float sum = 0;
            for (std::size_t i = 0; i < 9; ++i)
                sum += mosaic.weight(i, x, z);
            INFO("column " << x << ", " << z);
            CHECK(sum == Approx(1));
        }
    CHECK(mosaic.weight(4, 100, 120) == 1);
    CHECK(mosaic.weight(4, 50, 120) == Approx(0.5));
    CHECK(mosaic.weight(4, 0, 120) == 0);
    CHECK(mosaic.weight(4, 100, 200) == 0);
}

TEST_CASE("weights change little from column to column", "[voxelserver][voxelize][photo-mosaic]") {
    const PhotoMosaic mosaic({{0, 0, 100, 100}, {100, 0, 400, 300}, {0, 100, 100, 140}});
    for (std::size_t i = 0; i < 3; ++i)
        for (std::int32_t z = -300; z < 600; z += 13)
            for (std::int32_t x = -300; x < 800; ++x)
                REQUIRE(std::abs(mosaic.weight(i, x + 1, z) - mosaic.weight(i, x, z)) < 0.026F);
}

TEST_CASE("around an image are all that count in it", "[voxelserver][voxelize][photo-mosaic]") {
    const PhotoMosaic mosaic = three_by_three();
    CHECK(mosaic.around(0) == std::vector<std::size_t>{0, 1, 3, 4});
    CHECK(mosaic.around(4).size() == 9);
    CHECK(mosaic.around(5) == std::vector<std::size_t>{1, 2, 4, 5, 7, 8});
    for (std::size_t own = 0; own < 9; ++own)
        for (std::size_t i = 0; i < 9; ++i) {
            bool counts = false;
            const auto x0 = static_cast<std::int32_t>(own % 3) * 100 - 50;
            const auto z0 = static_cast<std::int32_t>(own / 3) * 80;
            for (std::int32_t z = z0; z < z0 + 80; ++z)
                for (std::int32_t x = x0; x < x0 + 100; ++x)
                    counts = counts || mosaic.weight(i, x, z) > 0;
            const auto around = mosaic.around(own);
            INFO("image " << i << " in image " << own);
            CHECK(counts == (std::find(around.begin(), around.end(), i) != around.end()));
        }
}

TEST_CASE("an image without columns counts nowhere", "[voxelserver][voxelize][photo-mosaic]") {
    const PhotoMosaic mosaic({{0, 0, 0, 0}, {0, 0, 100, 100}});
    CHECK(mosaic.weight(0, 0, 0) == 0);
    CHECK(mosaic.around(1) == std::vector<std::size_t>{1});
}

TEST_CASE("images of all sizes are found around each other",
          "[voxelserver][voxelize][photo-mosaic]") {
    std::vector<grid::ColumnRect> images;
    std::uint32_t random = 5;
    const auto number = [&](std::int32_t end) {
        random = random * 1664525U + 1013904223U;
        return static_cast<std::int32_t>((random >> 8) % static_cast<std::uint32_t>(end));
    };
    for (int i = 0; i < 60; ++i) {
        const std::int32_t x = number(2000) - 1000;
        const std::int32_t z = number(2000) - 1000;
        images.push_back({x, z, x + 1 + number(i % 7 == 0 ? 1500 : 90), z + 1 + number(200)});
    }
    const PhotoMosaic mosaic(images);
    // Where an image counts (its middle, less and plus its length) overlaps the other image; all
    // coordinates are doubled.
    const auto meets = [](std::int32_t min, std::int32_t max, std::int32_t own_min,
                          std::int32_t own_max) {
        return 2 * own_max > min + max - 2 * (max - min) &&
               2 * own_min < min + max + 2 * (max - min);
    };
    for (std::size_t own = 0; own < images.size(); ++own) {
        std::vector<std::size_t> wanted;
        for (std::size_t i = 0; i < images.size(); ++i)
            if (i == own ||
                (meets(images[i].min_x, images[i].max_x, images[own].min_x, images[own].max_x) &&
                 meets(images[i].min_z, images[i].max_z, images[own].min_z, images[own].max_z)))
                wanted.push_back(i);
        CHECK(mosaic.around(own) == wanted);
    }
}
