#include <fmt/format.h>

#include <algorithm>
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
constexpr std::array kNoises = {0.1, 0.05, 0.02};
constexpr int kMostSamples = 4096;
constexpr auto kPrimary = static_cast<std::size_t>(walk::RayKind::kPrimary);

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

scene::Scene valley_scene() {
    scene::Scene scene;
    scene.output.size_px = {96, 54};
    scene.sun.altitude_deg = 30;
    scene.sun.azimuth_deg = 240;
    scene.quality.coarse_step = 1;
    return scene;
}

LinearPicture traced(blocks::BlockManager& blocks, const Light& light, int samples, int seed,
                     int threads) {
    scene::Scene scene = valley_scene();
    scene.quality.samples = samples;
    scene.quality.seed = seed;
    light.set(scene);
    return trace_picture(shade::make_view(scene, blocks), blocks, threads).picture;
}

/// Root of the mean squared difference in brightness, as quality.noise counts it: shares of a
/// pixel's brightness, or of what is dark.
double relative_noise(const LinearPicture& found, const LinearPicture& reference) {
    constexpr double kDark = 0.02;
    const auto brightness = [](const LinearPicture& p, std::size_t i) {
        return static_cast<double>(voxel::luminance({p.rgb[i], p.rgb[i + 1], p.rgb[i + 2]}));
    };
    double sum = 0;
    for (std::size_t i = 0; i < found.rgb.size(); i += 3) {
        const double known = brightness(reference, i);
        const double off = (brightness(found, i) - known) / std::max(known, kDark);
        sum += off * off;
    }
    return std::sqrt(3 * sum / static_cast<double>(found.rgb.size()));
}

/// What is found where a noise is asked for.
void measure_noise(blocks::BlockManager& blocks, const Light& light, const LinearPicture& reference,
                   int threads, Readings& readings) {
    for (const double noise : kNoises) {
        scene::Scene scene = valley_scene();
        light.set(scene);
        scene.quality.samples = kMostSamples;
        scene.quality.seed = kSeed;
        scene.quality.noise = noise;
        const TracedPicture found = trace_picture(shade::make_view(scene, blocks), blocks, threads);
        const double pixels = static_cast<double>(found.picture.rgb.size()) / 3;
        const std::string name = fmt::format("{} with noise {}", light.name, noise);
        readings.add(name + ": noise / asked", "", relative_noise(found.picture, reference) / noise,
                     at_most(1));
        readings.add(name + ": samples of a pixel", "",
                     static_cast<double>(found.counts.trace.rays[kPrimary]) / pixels);
    }
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
        if (&light == &kLights.back())
            measure_noise(blocks, light, reference, c.threads, readings);
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
