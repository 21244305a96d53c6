#include "voxelserver/make/voxelize/steps/photo_mosaic.hpp"

#include <algorithm>
#include <cmath>

#include "tests/catch.hpp"

using namespace terravox;
using voxelize::PhotoMosaic;

namespace {

using Images = std::vector<imagery::Orthophotos::Input>;

Images list_images(const std::vector<grid::ColumnRect>& rects, std::size_t series = 0) {
    Images out;
    for (const grid::ColumnRect& rect : rects)
        out.push_back({rect, {}, series});
    return out;
}

/// Three by three images of 100 x 80 columns; the first is the north-western one.
Images three_by_three(std::size_t series = 0) {
    std::vector<grid::ColumnRect> images;
    for (std::int32_t z = 0; z < 3; ++z)
        for (std::int32_t x = 0; x < 3; ++x)
            images.push_back({100 * x - 50, 80 * z, 100 * x + 50, 80 * z + 80});
    return list_images(images, series);
}

/// How much an image counts in another one, at a column.
float weight(const PhotoMosaic& mosaic, std::size_t image, std::size_t within, std::int32_t x,
             std::int32_t z) {
    for (const PhotoMosaic::Weight& one : mosaic.weights(within, x, z))
        if (one.image == image)
            return one.weight;
    return 0;
}

}  // namespace

TEST_CASE("over equal images side by side the weights sum up to one",
          "[voxelserver][voxelize][photo-mosaic]") {
    const PhotoMosaic mosaic(three_by_three());
    for (std::int32_t z = 40; z <= 200; z += 7)
        for (std::int32_t x = 0; x <= 200; x += 9) {
            float sum = 0;
            for (const PhotoMosaic::Weight& one : mosaic.weights(4, x, z))
                sum += one.weight;
            INFO("column " << x << ", " << z);
            CHECK(sum == Approx(1));
        }
    CHECK(weight(mosaic, 4, 4, 100, 120) == 1);
    CHECK(weight(mosaic, 4, 4, 50, 120) == Approx(0.5));
    CHECK(weight(mosaic, 4, 4, 0, 120) == 0);
    CHECK(weight(mosaic, 4, 4, 100, 200) == 0);
}

TEST_CASE("weights change little from column to column", "[voxelserver][voxelize][photo-mosaic]") {
    // Four between two large ones, which count far beyond their edges: six in the middle.
    const PhotoMosaic mosaic(list_images({{0, 0, 100, 100},
                                          {100, 0, 200, 100},
                                          {0, 100, 100, 200},
                                          {100, 100, 200, 200},
                                          {200, -50, 500, 250},
                                          {-280, -40, 0, 260}}));
    REQUIRE(mosaic.around(0).size() == 6);
    std::size_t most = 0;
    for (std::int32_t z = -100; z < 300; z += 13)
        for (std::int32_t x = -300; x < 500; ++x) {
            most = std::max(most, mosaic.weights(0, x, z).size());
            for (std::size_t i = 0; i < 6; ++i)
                REQUIRE(std::abs(weight(mosaic, i, 0, x + 1, z) - weight(mosaic, i, 0, x, z)) <
                        0.04F);
        }
    CHECK(most == PhotoMosaic::kMostImages);
}

TEST_CASE("around an image are all that count in it", "[voxelserver][voxelize][photo-mosaic]") {
    const PhotoMosaic mosaic(three_by_three());
    CHECK(mosaic.around(0) == std::vector<std::size_t>{0, 1, 3, 4});
    CHECK(mosaic.around(4).size() == 9);
    CHECK(mosaic.around(5) == std::vector<std::size_t>{1, 2, 4, 5, 7, 8});
}

TEST_CASE("an image without columns counts nowhere", "[voxelserver][voxelize][photo-mosaic]") {
    const PhotoMosaic mosaic(list_images({{0, 0, 0, 0}, {0, 0, 100, 100}}));
    CHECK(weight(mosaic, 0, 1, 0, 0) == 0);
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
    for (int i = 0; i < 90; ++i) {
        const std::int32_t x = number(2000) - 1000;
        const std::int32_t z = number(2000) - 1000;
        const grid::ColumnRect image{x, z, x + 1 + number(i % 7 == 0 ? 1500 : 90),
                                     z + 1 + number(200)};
        // All in one mosaic: none lies on another.
        if (std::none_of(images.begin(), images.end(),
                         [&](const grid::ColumnRect& other) { return other.overlaps(image); }))
            images.push_back(image);
    }
    REQUIRE(images.size() > 40);
    const PhotoMosaic mosaic(list_images(images));
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

TEST_CASE("years of one place are mosaics of their own", "[voxelserver][voxelize][photo-mosaic]") {
    Images newer = three_by_three();
    SECTION("by their dates or pixels") {
        for (const auto& image : three_by_three(1))
            newer.push_back(image);
    }
    SECTION("by what they cover") {
        for (const auto& image : three_by_three(0))
            newer.push_back(image);
    }
    SECTION("by what they cover, cut in another way") {
        // A quarter of each lies on each of four newer ones.
        for (std::int32_t z = 0; z < 2; ++z)
            for (std::int32_t x = 0; x < 2; ++x)
                newer.push_back({{100 * x, 80 * z + 40, 100 * x + 100, 80 * z + 120}, {}, 0});
    }
    const PhotoMosaic mosaic(newer);
    CHECK(mosaic.around(4) == std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7, 8});
    const auto older = mosaic.around(9);
    CHECK(older.size() == 4);
    CHECK(older.front() == 9);
}

TEST_CASE("few images count where a drone took many", "[voxelserver][voxelize][photo-mosaic]") {
    // Frames of 100 x 70 columns that overlap by 80 and by 60 percent.
    std::vector<grid::ColumnRect> frames;
    for (std::int32_t z = 0; z < 10; ++z)
        for (std::int32_t x = 0; x < 10; ++x)
            frames.push_back({20 * x, 28 * z, 20 * x + 100, 28 * z + 70});
    const PhotoMosaic mosaic(list_images(frames));
    for (std::size_t own = 0; own < frames.size(); ++own) {
        const grid::ColumnRect& rect = frames[own];
        for (std::int32_t z = rect.min_z; z < rect.max_z; z += 9)
            for (std::int32_t x = rect.min_x; x < rect.max_x; x += 9)
                REQUIRE(mosaic.weights(own, x, z).size() <= PhotoMosaic::kMostImages);
        for (const std::size_t other : mosaic.around(own))
            if (other != own) {
                const std::int32_t dx = std::abs(frames[other].min_x - rect.min_x);
                const std::int32_t dz = std::abs(frames[other].min_z - rect.min_z);
                CHECK((dx >= 100 || dz >= 70 || 2 * (100 - dx) * (70 - dz) < 100 * 70));
            }
    }
}

TEST_CASE("images that overlap at their edges are one mosaic, in any order",
          "[voxelserver][voxelize][photo-mosaic]") {
    // By 12 of 100 columns on each side: the others cover 42 % of the middle one, and 54 % where
    // corners count for each of them.
    std::vector<grid::ColumnRect> rects;
    for (std::int32_t z = 0; z < 3; ++z)
        for (std::int32_t x = 0; x < 3; ++x)
            rects.push_back({88 * x, 88 * z, 88 * x + 100, 88 * z + 100});
    SECTION("the middle one last") {
        std::swap(rects[4], rects[8]);
    }
    SECTION("in order") {}
    const PhotoMosaic mosaic(list_images(rects));
    for (std::size_t i = 0; i < rects.size(); ++i)
        CHECK(mosaic.around(i).size() >= 4);
    CHECK(mosaic.around(4).size() + mosaic.around(8).size() == 9 + 4);
}
