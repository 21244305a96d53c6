#include <cmath>
#include <fstream>
#include <limits>

#include "common/util/error.hpp"
#include "raytracer/sky/sky.hpp"
#include "tests/bench/entries/light_picture.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::bench;

TEST_CASE("pictures are compared over all pixels and channels", "[bench][light]") {
    const LinearPicture a{2, 1, {1, 2, 3, 4, 5, 6}};
    const LinearPicture b{2, 1, {1, 2, 3, 4, 5, 0}};
    CHECK(mean_of(a) == Approx(3.5));
    CHECK(rms_difference(a, a) == 0);
    CHECK(rms_difference(a, b) == Approx(std::sqrt(6.0)));
    CHECK(noise_of(a, b) == Approx(std::sqrt(3.0)));
    CHECK_THROWS_AS(rms_difference(a, LinearPicture{1, 1, {1, 2, 3}}), util::Error);
}

TEST_CASE("a picture comes back from its file, and another file is refused", "[bench][light]") {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "picture.f32";
    const LinearPicture picture{1, 2, {0, 0.25f, 1e6f, 1, 2, 3}};
    write_picture(file, picture);
    CHECK(read_picture(file, 1, 2).rgb == picture.rgb);
    CHECK_THROWS_AS(read_picture(file, 1, 1), util::Error);
    CHECK_THROWS_AS(read_picture(file, 2, 2), util::Error);
    CHECK_THROWS_AS(read_picture(folder.path() / "none.f32", 1, 2), util::Error);
    write_picture(file, {1, 1, {0, std::numeric_limits<float>::infinity(), 0}});
    CHECK_THROWS_AS(read_picture(file, 1, 1), util::Error);
}

TEST_CASE("a scene's sun stands where it was set", "[bench][light]") {
    for (const core::Vec3 wanted :
         {core::normalized({0.5, 0.7, 0.3}), core::normalized({-0.2, 0.1, -0.9}),
          core::normalized({-0.6, 0.5, 0.1})}) {
        scene::Scene scene;
        set_sun(scene, wanted);
        const sky::Sky sky({*scene.sun.altitude_deg, *scene.sun.azimuth_deg}, scene.sun, scene.sky,
                           0);
        CHECK(core::dot(sky.to_sun(), wanted) == Approx(1).epsilon(1e-9));
    }
}
