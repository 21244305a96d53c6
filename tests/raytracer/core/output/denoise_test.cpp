#include "raytracer/core/output/denoise.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;

namespace {

bool oidn_is_here() {
    try {
        output::check_can_denoise();
        return true;
    } catch (const util::UsageError& e) {
        WARN("not tested: " << e.what());
        return false;
    }
}

constexpr int kSize = 128;

/// Two flat fields that meet at the middle column, each with noise.
output::Film noisy(bool with_layers) {
    std::mt19937 random(8);
    std::exponential_distribution<float> noise(1);
    output::Film film(kSize, kSize, with_layers);
    tiles::TileResult all;
    all.tile.x1 = all.tile.y1 = kSize;
    all.tile.each_pixel([&](int x, int) {
        const float light = (x < kSize / 2 ? 0.2f : 3.0f) * noise(random);
        all.samples.push_back({{light, light, light}, 0.75f, 12});
        tiles::LayerSample l;
        l.albedo =
            x < kSize / 2 ? voxel::Colour{0.1f, 0.1f, 0.1f} : voxel::Colour{0.9f, 0.9f, 0.9f};
        l.normal = {0, 1, 0};
        all.layers.push_back(l);
    });
    film.add(all);
    return film;
}

/// Mean and relative spread of columns [x0, x1).
std::array<double, 2> field(const output::Film& film, int x0, int x1) {
    double sum = 0;
    double squares = 0;
    double n = 0;
    for (int y = 4; y < kSize - 4; ++y)
        for (int x = x0; x < x1; ++x) {
            sum += film.at(x, y).colour.g;
            squares += std::pow(film.at(x, y).colour.g, 2);
            ++n;
        }
    return {sum / n, std::sqrt(std::max(0.0, squares / n - std::pow(sum / n, 2))) / (sum / n)};
}

}  // namespace

TEST_CASE("denoising takes noise out, keeps edges and brightness, and nothing but colours changes",
          "[raytracer][output][denoise]") {
    if (!oidn_is_here())
        return;
    const output::Film before = noisy(true);
    output::Film film = before;
    output::Film again = before;
    output::denoise(film, 2);
    output::denoise(again, 1);
    for (const auto& [x0, x1] : {std::pair{4, 60}, {68, 124}}) {
        const auto [old_mean, old_spread] = field(before, x0, x1);
        const auto [mean, spread] = field(film, x0, x1);
        INFO("columns from " << x0);
        CHECK(spread < old_spread / 5);
        CHECK(mean == Approx(old_mean).epsilon(0.1));
    }
    CHECK(field(film, 66, 70)[0] > 5 * field(film, 58, 62)[0]);
    CHECK(film.at(3, 3).alpha == 0.75f);
    CHECK(film.at(3, 3).depth_m == 12);
    int differ = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x)
            differ += film.at(x, y).colour.g == again.at(x, y).colour.g ? 0 : 1;
    CHECK(differ == 0);
}

TEST_CASE("light without bound does not spread", "[raytracer][output][denoise]") {
    if (!oidn_is_here())
        return;
    output::Film film = noisy(true);
    film.set_colour(20, 20, {std::numeric_limits<float>::infinity(), std::nanf(""), 1});
    output::denoise(film, 1);
    int bad = 0;
    for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x)
            bad += std::isfinite(film.at(x, y).colour.r) && std::isfinite(film.at(x, y).colour.g)
                       ? 0
                       : 1;
    CHECK(bad == 0);
}

TEST_CASE("a film without layers is not denoised", "[raytracer][output][denoise]") {
    output::Film film = noisy(false);
    CHECK_THROWS_WITH(output::denoise(film, 1), contains("no layers"));
}

TEST_CASE("a missing library is reported, with how to install it", "[raytracer][output][denoise]") {
    // A loaded library stays loaded, so this needs a new process.
    const auto said_by_child = [](const char* value) {
        std::fflush(nullptr);
        std::string said(2000, '\0');
        FILE* pipe = ::popen(("TERRAVOX_OIDN='" + std::string(value) + "' '" + "/proc/" +
                              std::to_string(::getpid()) + "/exe' '[.oidn]' 2>&1")
                                 .c_str(),
                             "r");
        REQUIRE(pipe != nullptr);
        said.resize(std::fread(said.data(), 1, said.size(), pipe));
        ::pclose(pipe);
        return said;
    };
    CHECK_THAT(said_by_child("/nowhere"),
               contains("usage error: denoise the picture: TERRAVOX_OIDN = '/nowhere'"));
    const test::TemporaryFolder empty;
    CHECK_THAT(said_by_child(empty.path().c_str()), contains("no libOpenImageDenoise.so there"));
}

TEST_CASE("prints what asking for Open Image Denoise gives", "[.oidn]") {
    try {
        output::check_can_denoise();
        std::puts(output::OidnLibrary::get().file.c_str());
    } catch (const util::UsageError& e) {
        std::printf("usage error: %s\n", e.what());
    }
}
