#include <cmath>

#include "raytracer/shade/view_maker.hpp"
#include "tests/bench/entries/light_picture.hpp"
#include "tests/raytracer/landscape.hpp"

namespace terravox::bench::light_convergence_entry {
namespace {

constexpr int kReferenceSamples = 4096;
constexpr int kReferenceSeed = 7;
constexpr int kSeed = 1;
constexpr std::array kSamples = {4, 16, 64, 256};

/// A kind of light that is known by samples alone.
struct Light {
    const char* name;
    void (*set)(scene::Scene&);
};
const std::array kLights = {
    Light{"ambient-occlusion rays",
          [](scene::Scene& s) {
              s.quality.ao_rays = 1;
              s.sun.strength = 0;
          }},
    Light{"soft shadows",
          [](scene::Scene& s) {
              s.sun.size = 20;
              s.quality.ambient_occlusion = false;
          }},
    Light{"paths", [](scene::Scene& s) { s.quality.integrator = core::Integrator::kPath; }},
};

LinearPicture traced(blocks::BlockManager& blocks, const Light& light, int samples, int seed,
                     int threads) {
    scene::Scene scene;
    scene.output.size_px = {96, 54};
    scene.sun.altitude_deg = 30;
    scene.sun.azimuth_deg = 240;
    scene.quality.coarse_step = 1;
    scene.quality.samples = samples;
    scene.quality.seed = seed;
    light.set(scene);
    return trace_picture(shade::make_view(scene, blocks), blocks, threads).picture;
}

void measure(const Context& c, Readings& readings) {
    const auto world = test::landscape();
    blocks::BlockManager blocks(*world, std::size_t{256} << 20);
    for (const Light& light : kLights) {
        const LinearPicture reference =
            traced(blocks, light, kReferenceSamples, kReferenceSeed, c.threads);
        const double mean = mean_of(reference);
        double first = 0;
        double last = 0;
        for (const int samples : kSamples) {
            last =
                rms_difference(traced(blocks, light, samples, kSeed, c.threads), reference) / mean;
            if (first == 0)
                first = last;
            readings.add(std::string(light.name) + ": error of " + std::to_string(samples) +
                             " samples / mean",
                         "%", 100 * last);
        }
        const double power =
            std::log(last / first) / std::log(double{kSamples.back()} / kSamples.front());
        readings.add(std::string(light.name) + ": power of the number of samples", "", power,
                     at_most(-0.5));
    }
}

Entry entry() {
    Entry out;
    out.name = "light/convergence";
    out.measures =
        "how the error of a picture falls with its samples: to 4096 samples of another seed, share "
        "of the picture's mean";
    out.work =
        "the small valley of the tests, 96x54: ambient-occlusion rays, a sun of twenty times the "
        "true radius, paths; 4 to 256 samples";
    out.exact = out.only_by_name = true;
    out.missing = [](const Context&) { return std::string(); };
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) { measure(c, readings); };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::light_convergence_entry
