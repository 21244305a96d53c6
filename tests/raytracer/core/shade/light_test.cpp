#include <cmath>
#include <cstdlib>
#include <vector>

#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using terravox::test::Job;
using terravox::test::render_scene;
using terravox::test::small_scene;

namespace {

scene::Scene tiny(core::Integrator integrator, int samples) {
    scene::Scene scene = small_scene();
    scene.output.size_px = {40, 24};
    scene.quality.integrator = integrator;
    scene.quality.samples = samples;
    scene.quality.coarse_step = 1;
    return scene;
}

double rmse(const output::Film& a, const output::Film& b) {
    double sum = 0;
    for (int y = 0; y < a.height_px(); ++y)
        for (int x = 0; x < a.width_px(); ++x) {
            const voxel::Colour p = a.at(x, y).colour;
            const voxel::Colour q = b.at(x, y).colour;
            for (const float d : {p.r - q.r, p.g - q.g, p.b - q.b})
                sum += static_cast<double>(d) * static_cast<double>(d);
        }
    return std::sqrt(sum / (3.0 * a.width_px() * a.height_px()));
}

output::Film picture(const scene::Scene& scene) {
    Job job(scene);
    return render_scene(job, 2);
}

/// What the scene's paths converge to.
const output::Film& converged_paths() {
    static const output::Film film = picture(tiny(core::Integrator::kPath, 1024));
    return film;
}

}  // namespace

TEST_CASE("light of any kind comes closer to its mean with more samples",
          "[raytracer][shade][light][all]") {
    struct Kind {
        const char* name;
        void (*set)(scene::Scene&);
    };
    const Kind kinds[] = {
        {"ambient occlusion", [](scene::Scene& s) { s.quality.ao_rays = 1; }},
        {"a large sun", [](scene::Scene& s) { s.sun.size = 20; }},
        {"paths", [](scene::Scene& s) { s.quality.integrator = core::Integrator::kPath; }},
    };
    for (const Kind& kind : kinds) {
        scene::Scene scene = tiny(core::Integrator::kDirect, 1024);
        kind.set(scene);
        const output::Film reference = picture(scene);
        double last = 0;
        for (const int samples : {4, 16, 64}) {
            scene.quality.samples = samples;
            const output::Film film = picture(scene);
            const double error = rmse(film, reference);
            INFO(kind.name << ", " << samples << " samples: error " << error
                           << ", with a quarter of them " << last);
            // 1 / sqrt(n) halves it; evenly spread samples do better, edges of voxels a little
            // worse.
            if (last > 0)
                CHECK(error < last * 0.62);
            last = error;
        }
    }
}

TEST_CASE("a pixel's estimate of its error is about its error", "[raytracer][shade][light]") {
    const output::Film& reference = converged_paths();
    const output::Film film = picture(tiny(core::Integrator::kPath, 16));
    double said = 0;
    double found = 0;
    for (int y = 0; y < film.height_px(); ++y)
        for (int x = 0; x < film.width_px(); ++x) {
            const double d = static_cast<double>(voxel::luminance(film.at(x, y).colour) -
                                                 voxel::luminance(reference.at(x, y).colour));
            found += d * d;
            said +=
                static_cast<double>(film.at(x, y).error) * static_cast<double>(film.at(x, y).error);
        }
    // Evenly spread samples do better than the formula for independent ones.
    CHECK(std::sqrt(found) < std::sqrt(said) * 1.1);
    CHECK(std::sqrt(found) > std::sqrt(said) * 0.3);
}

TEST_CASE("with a noise to reach, samples go where they are needed", "[raytracer][shade][light]") {
    scene::Scene scene = tiny(core::Integrator::kPath, 512);
    scene.quality.noise = 0.05;
    scene.quality.min_samples = 8;
    const output::Film film = picture(scene);
    const output::Film& reference = converged_paths();
    std::uint64_t samples = 0;
    std::uint32_t least = 1 << 20;
    std::uint32_t most = 0;
    for (int y = 0; y < film.height_px(); ++y)
        for (int x = 0; x < film.width_px(); ++x) {
            const tiles::PixelSample& p = film.at(x, y);
            samples += p.samples;
            least = std::min(least, p.samples);
            most = std::max(most, p.samples);
            CHECK((p.samples == 512 || p.is_known(0.05)));
        }
    CHECK(least == 8);
    CHECK(most > 32);
    scene.quality.noise = 0;
    scene.quality.samples = static_cast<int>(samples / (40 * 24));
    INFO(samples / (40.0 * 24) << " samples a pixel");
    CHECK(rmse(film, reference) < 1.1 * rmse(picture(scene), reference));
}

TEST_CASE("more samples added later make the mean of all", "[raytracer][shade][light]") {
    const scene::Scene scene = tiny(core::Integrator::kPath, 8);
    Job job(scene);
    const output::Film whole = render_scene(job, 1);
    output::Film film(40, 24);
    {
        processors::ThreadProcessor processor(job.view, job.blocks, 1);
        tiles::RenderTile tile{0, 0, 0, 0, 40, 24, 1, false, 0, 0};
        for (const auto& [first, count] : {std::pair{0u, 2u}, {2u, 2u}, {4u, 4u}}) {
            tile.first_sample = first;
            tile.samples = count;
            processor.submit(tile);
            film.add(*processor.take());
        }
    }
    CHECK(rmse(whole, film) < 1e-6);
    double errors = 0;
    for (int y = 0; y < 24; ++y)
        for (int x = 0; x < 40; ++x) {
            CHECK(film.at(x, y).samples == 8);
            CHECK(film.at(x, y).alpha == Approx(whole.at(x, y).alpha).margin(1e-6));
            if (whole.at(x, y).alpha > 0)
                CHECK(film.at(x, y).depth_m == Approx(whole.at(x, y).depth_m).epsilon(1e-4));
            errors +=
                static_cast<double>(film.at(x, y).error / std::max(whole.at(x, y).error, 1e-6f)) /
                (40 * 24);
        }
    CHECK(errors < 1.5);
}

TEST_CASE(
    "with a time to keep a picture has at least its first samples, and with a noise, too, those "
    "that were requested",
    "[raytracer][shade][light]") {
    scene::Scene scene = tiny(core::Integrator::kDirect, 64);
    scene.quality.time_s = 0.001;
    CHECK(picture(scene).at(3, 3).samples >= 2);
    scene.quality.time_s = 1000;
    CHECK(picture(scene).at(3, 3).samples == 64);
    scene.quality.noise = 1;
    scene.quality.min_samples = 16;
    CHECK(picture(scene).at(3, 3).samples >= 16);
}
