#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/util/error.hpp"
#include "raytracer/core/shade/view.hpp"
#include "raytracer/farm/processors/thread_processor.hpp"
#include "raytracer/farm/render/passes/passes.hpp"
#include "tests/bench/bench.hpp"
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

/// A picture in linear light, r, g, b of each pixel, and how many rays went through pixels.
struct Traced {
    std::vector<float> rgb;
    std::size_t rays = 0;
};

/// As the program traces a scene, in a single pass.
Traced traced(blocks::BlockManager& blocks, const scene::Scene& scene, int threads) {
    const shade::View view = shade::make_view(scene, blocks);
    const auto [width, height] = view.scene.output.size_px;
    output::Film film(width, height);
    processors::ThreadProcessor processor(view, blocks, threads);
    const render::RenderCounts counts = render::render_film({view, processor, true, {}}, film);
    if (counts.trace.hole_rays != 0)
        throw util::Error("trace the valley: " + std::to_string(counts.trace.hole_rays) +
                          " rays met holes");
    Traced out;
    out.rays = counts.trace.rays[kPrimary];
    for (const tiles::PixelSample& pixel : film.samples())
        out.rgb.insert(out.rgb.end(), {pixel.colour.r, pixel.colour.g, pixel.colour.b});
    return out;
}

scene::Scene lit_scene(const Light& light, int samples, int seed) {
    scene::Scene scene = valley_scene();
    scene.quality.samples = samples;
    scene.quality.seed = seed;
    light.set(scene);
    return scene;
}

double measure_mean(const Traced& picture) {
    double sum = 0;
    for (const float v : picture.rgb)
        sum += static_cast<double>(v);
    return sum / static_cast<double>(picture.rgb.size());
}

double rms_difference(const Traced& a, const Traced& b) {
    double sum = 0;
    for (std::size_t i = 0; i < a.rgb.size(); ++i) {
        const double d = static_cast<double>(a.rgb[i]) - static_cast<double>(b.rgb[i]);
        sum += d * d;
    }
    return std::sqrt(sum / static_cast<double>(a.rgb.size()));
}

/// Root of the mean squared difference in brightness, as quality.noise counts it: shares of a
/// pixel's brightness, or of what is dark.
double relative_noise(const Traced& found, const Traced& reference) {
    constexpr double kDark = 0.02;
    const auto brightness = [](const Traced& p, std::size_t i) {
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
void measure_noise(blocks::BlockManager& blocks, const Light& light, const Traced& reference,
                   int threads, Readings& readings) {
    for (const double noise : kNoises) {
        scene::Scene scene = lit_scene(light, kMostSamples, kSeed);
        scene.quality.noise = noise;
        const Traced found = traced(blocks, scene, threads);
        const double pixels = static_cast<double>(found.rgb.size()) / 3;
        const std::string name = fmt::format("{} with noise {}", light.name, noise);
        readings.add(name + ": noise / asked", "", relative_noise(found, reference) / noise,
                     at_most(1));
        readings.add(name + ": samples of a pixel", "", static_cast<double>(found.rays) / pixels);
    }
}

void measure(const Context& c, Readings& readings) {
    const auto world = test::landscape();
    blocks::BlockManager blocks(*world, std::size_t{256} << 20);
    for (const Light& light : kLights) {
        const Traced reference =
            traced(blocks, lit_scene(light, kReferenceSamples, kReferenceSeed), c.threads);
        const double mean = measure_mean(reference);
        double first = 0;
        double last = 0;
        for (const int samples : kSamples) {
            last = rms_difference(traced(blocks, lit_scene(light, samples, kSeed), c.threads),
                                  reference) /
                   mean;
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
