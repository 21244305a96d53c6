#include "raytracer/core/trace/sample_accumulator.hpp"

#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using terravox::test::Job;
using terravox::test::small_scene;

namespace {

shade::SampleSum make_sample(double brightness) {
    shade::SampleSum out;
    const auto value = static_cast<float>(brightness);
    out.direct = {value, value, value};
    return out;
}

}  // namespace

TEST_CASE("samples become the means of pixels, each in its place", "[raytracer][trace]") {
    scene::Scene scene = small_scene();
    scene.quality.samples = 2;
    const Job job(scene);
    trace::SampleAccumulator sums;
    sums.begin_tile(3, false);
    trace::TilePixel last;
    last.place = 2;
    trace::TilePixel first;
    first.place = 0;
    const std::vector<trace::TilePixel> pixels{last, first};

    sums.begin_part(pixels.size());
    const std::vector<shade::SampleSum> low{make_sample(1), make_sample(10)};
    CHECK(sums.add_round(low, job.view, 0));
    CHECK(sums.round() == 1);
    const std::vector<shade::SampleSum> high{make_sample(3), make_sample(30)};
    CHECK_FALSE(sums.add_round(high, job.view, 0));
    sums.end_part(pixels, job.view.voxel_m);

    const auto means = sums.take_samples();
    REQUIRE(means.size() == 3);
    CHECK(means[2].colour.g == 2);
    CHECK(means[0].colour.g == 20);
    CHECK(means[0].samples == 2);
    CHECK(sums.take_layers().empty());
}

TEST_CASE("a tile may want fewer samples than its scene", "[raytracer][trace]") {
    scene::Scene scene = small_scene();
    scene.quality.samples = 64;
    const Job job(scene);
    trace::SampleAccumulator sums;
    sums.begin_tile(1, false);
    sums.begin_part(1);
    const std::vector<shade::SampleSum> one{make_sample(1)};
    CHECK(sums.add_round(one, job.view, 2));
    CHECK_FALSE(sums.add_round(one, job.view, 2));
}

TEST_CASE("a pixel that is known well enough needs no more samples", "[raytracer][trace]") {
    scene::Scene scene = small_scene();
    scene.quality.samples = 64;
    scene.quality.min_samples = 4;
    scene.quality.noise = 0.01;
    const Job job(scene);
    trace::SampleAccumulator sums;
    sums.begin_tile(2, false);
    sums.begin_part(2);
    // The first pixel is the same each time, the second is not.
    for (int round = 0; round < 3; ++round) {
        const std::vector<shade::SampleSum> both{make_sample(5),
                                                 make_sample(round % 2 == 0 ? 1 : 9)};
        CHECK(sums.add_round(both, job.view, 0));
        CHECK(sums.active().size() == 2);
    }
    const std::vector<shade::SampleSum> both{make_sample(5), make_sample(9)};
    CHECK(sums.add_round(both, job.view, 0));
    REQUIRE(sums.active().size() == 1);
    CHECK(sums.active().front() == 1);
}
