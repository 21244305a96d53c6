#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "tests/catch.hpp"
#include "voxelserver/make/voxelize/steps/photo_light.hpp"
#include "voxelserver/make/voxelize/steps/photo_mosaic.hpp"

using namespace terravox;
using voxelize::PhotoLight;
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

PhotoLight made_light() {
    PhotoLight out;
    out.light.sun = sunlight::Sun{150, 40};
    out.light.sky = {0.2F, 0.25F, 0.3F};
    out.light.veil = {0.01F, 0.02F, 0};
    out.light.gain = {1.25F, 1, 0.5F};
    out.light.typical = {0, 0.1F, 0.2F, 0.3F, 0.4F};
    out.estimate = {{151, 41}, -0.5, 0.25};
    out.evidence.seen[1] = {{0.1F, 0.2F, 0.05F}, 1234};
    out.evidence.darkest = {0.01F, 0.02F, 0.03F};
    out.evidence.cells = 5678;
    return out;
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

TEST_CASE("exposure is found from all images of a series, and from as many of very many",
          "[voxelserver][voxelize][photo-light]") {
    Images few = three_by_three(4);
    few.push_back({{0, 0, 100, 80}, {}, 7});
    const auto all = voxelize::exposure_images(few);
    CHECK(all.at(4) == std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7, 8});
    CHECK(all.at(7) == std::vector<std::size_t>{9});

    std::vector<grid::ColumnRect> rects;
    for (std::int32_t i = 0; i < 400; ++i)
        rects.push_back({100 * (i % 20), 80 * (i / 20), 100 * (i % 20) + 100, 80 * (i / 20) + 80});
    const auto places_of = [](const std::vector<grid::ColumnRect>& of) {
        std::vector<std::pair<std::int32_t, std::int32_t>> out;
        const auto by_series = voxelize::exposure_images(list_images(of));
        for (const std::size_t i : by_series.at(0))
            out.emplace_back(of[i].min_x, of[i].min_z);
        std::sort(out.begin(), out.end());
        return out;
    };
    const auto chosen = places_of(rects);
    CHECK(chosen.size() == voxelize::kExposureImages);
    // Spread, and the same in any order.
    CHECK(chosen.back().first - chosen.front().first > 1000);
    std::reverse(rects.begin(), rects.end());
    CHECK(places_of(rects) == chosen);
    // One that is added takes the place of one at most.
    rects.push_back({5000, 5000, 5100, 5080});
    const auto more = places_of(rects);
    CHECK(std::count_if(chosen.begin(), chosen.end(), [&](const auto& place) {
              return std::find(more.begin(), more.end(), place) != more.end();
          }) >= static_cast<std::ptrdiff_t>(voxelize::kExposureImages) - 1);
}

TEST_CASE("the light of a photograph is read as it was written",
          "[voxelserver][voxelize][photo-light]") {
    PhotoLight light = made_light();
    SECTION("with a sun") {}
    SECTION("without one") {
        light.light.sun.reset();
    }
    const auto read = voxelize::parse_photo_light(to_bytes(light));
    REQUIRE(read);
    REQUIRE(read->light.sun.has_value() == light.light.sun.has_value());
    CHECK(read->light.typical == light.light.typical);
    CHECK(read->estimate.sun.azimuth_deg == light.estimate.sun.azimuth_deg);
    CHECK(read->estimate.margin == light.estimate.margin);
    CHECK(read->evidence.seen[1].albedo == light.evidence.seen[1].albedo);
    CHECK(read->evidence.seen[1].cells == 1234);
    CHECK(read->evidence.darkest == light.evidence.darkest);
    CHECK(read->evidence.cells == 5678);
    CHECK(to_bytes(*read) == to_bytes(light));
}

TEST_CASE("what is no light of a photograph is not taken for one",
          "[voxelserver][voxelize][photo-light]") {
    const std::string good = to_bytes(made_light());
    for (std::size_t length = 0; length < good.size(); ++length)
        CHECK_FALSE(voxelize::parse_photo_light(std::string_view(good).substr(0, length)));
    CHECK_FALSE(voxelize::parse_photo_light(good + "x"));
    std::string other_version = good;
    ++other_version[0];
    CHECK_FALSE(voxelize::parse_photo_light(other_version));

    constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
    std::vector<PhotoLight> wrong(13, made_light());
    wrong[0].light.sky[1] = 0;
    wrong[1].light.sky[1] = kNan;
    wrong[2].light.veil[2] = -0.1F;
    wrong[3].light.gain[0] = 0;
    wrong[4].light.gain[0] = std::numeric_limits<float>::infinity();
    wrong[5].light.typical[3] = kNan;
    wrong[6].light.sun->altitude_deg = 0;
    wrong[7].light.sun->azimuth_deg = kNan;
    wrong[8].estimate.correlation = 2;
    wrong[9].estimate.correlation = static_cast<double>(kNan);
    wrong[10].estimate.margin = -1;
    wrong[11].evidence.seen[0].albedo[1] = kNan;
    wrong[12].evidence.darkest[2] = -1;
    for (std::size_t i = 0; i < wrong.size(); ++i) {
        INFO("case " << i);
        CHECK_FALSE(voxelize::parse_photo_light(to_bytes(wrong[i])));
    }
}
