#include <cmath>
#include <numbers>

#include "common/util/error.hpp"
#include "tests/bench/entries/light_neutral.hpp"

namespace terravox::bench::light_cached_entry {
namespace {

constexpr int kPathSamples = 64;
constexpr int kSamples = 16;
constexpr double kMaxMeanDifference = 0.01;  // above it kept light is not that of paths
constexpr int kPart = 4;  // the edges of a view are so many times those of its middle

/// The middle of a view, at the scale of the whole.
scene::Scene scene_of(const NeutralView& view, int samples, int seed) {
    scene::Scene scene = NeutralLight::scene_of(view, samples);
    constexpr double kDegrees = 180 / std::numbers::pi;
    scene.output.size_px = {NeutralScene::kWidthPx / kPart, NeutralScene::kHeightPx / kPart};
    scene.camera.fov_deg = 2 * kDegrees * std::atan(std::tan(view.fov_deg / 2 / kDegrees) / kPart);
    scene.quality.seed = seed;
    return scene;
}

/// Root of the mean squared error of a picture. Two other pictures without bias, whose errors have
/// nothing in common, take the place of the truth: their errors cancel out of the product.
double error_of(const LinearPicture& picture, const LinearPicture& a, const LinearPicture& b) {
    double sum = 0;
    for (std::size_t i = 0; i < picture.rgb.size(); ++i)
        sum += (static_cast<double>(picture.rgb[i]) - static_cast<double>(a.rgb[i])) *
               (static_cast<double>(picture.rgb[i]) - static_cast<double>(b.rgb[i]));
    return std::sqrt(std::max(sum / static_cast<double>(picture.rgb.size()), 0.0));
}

/// Two pictures that differ in their seed.
struct Pair {
    std::array<TracedPicture, 2> pictures;
    [[nodiscard]] double mean() const {
        return (mean_of(pictures[0].picture) + mean_of(pictures[1].picture)) / 2;
    }
    [[nodiscard]] double noise() const {
        return noise_of(pictures[0].picture, pictures[1].picture);
    }
    [[nodiscard]] double cpu_s() const noexcept {
        return std::min(pictures[0].cost.cpu_s, pictures[1].cost.cpu_s);
    }
};

void add_view(NeutralLight& light, const NeutralView& view, int threads, Readings& readings) {
    const std::string name = view.name;
    Pair paths;
    Pair cached;
    for (int i = 0; i < 2; ++i) {
        const auto at = static_cast<std::size_t>(i);
        paths.pictures[at] = light.trace(scene_of(view, kPathSamples, i + 1), threads);
        scene::Scene scene = scene_of(view, kSamples, i + 1);
        scene.quality.integrator = core::Integrator::kCached;
        cached.pictures[at] = light.trace(scene, threads);
    }
    const double mean = paths.mean();
    const double mean_ratio = cached.mean() / mean;
    if (!(std::abs(mean_ratio - 1) < kMaxMeanDifference))
        throw util::Error("compare kept light with paths: " + name + ": the means differ by " +
                          std::to_string(100 * (mean_ratio - 1)) + " %");
    const double error =
        error_of(cached.pictures[0].picture, paths.pictures[0].picture, paths.pictures[1].picture);
    readings.add(name + ": paths: CPU time", "s", paths.cpu_s());
    readings.add(name + ": paths: noise / mean", "%", 100 * paths.noise() / mean);
    readings.add(name + ": cached: CPU time", "s", cached.cpu_s());
    readings.add(name + ": cached: noise / mean", "%", 100 * cached.noise() / mean);
    readings.add(name + ": cached: error / mean", "%", 100 * error / mean, at_most(1));
    readings.add(name + ": cached: mean / paths' mean", "x", mean_ratio);
    const double path_variance = paths.noise() * paths.noise();
    readings.add(name + ": time to the same error / paths", "x",
                 cached.cpu_s() * error * error / (paths.cpu_s() * path_variance), at_most(0.2));
    readings.note(rays_of(name + ", paths", paths.pictures[0].counts));
    readings.note(rays_of(name + ", cached", cached.pictures[0].counts));
}

Entry entry() {
    Entry out;
    out.name = "light/cached";
    out.measures =
        "paths that end in the kept irradiance of faces, against paths: processor time, noise, "
        "error, time to the same error; the means must agree";
    out.work =
        "the voxels and light of light/cycles, the middle 320x180 pixels of its three cameras, two "
        "seeds; 64 samples of paths, 16 of kept light with 16 gather rays";
    out.missing = NeutralScene::missing;
    out.only_by_name = true;
    out.prepare = [](const Context& c) -> Body {
        const auto light = std::make_shared<NeutralLight>(c);
        return [light, &c](Readings& readings) {
            for (const NeutralView& view : neutral_views())
                add_view(*light, view, c.threads, readings);
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::light_cached_entry
