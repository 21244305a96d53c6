#include "raytracer/trace/batch_means.hpp"

#include <cmath>
#include <functional>

#include "raytracer/core/random.hpp"
#include "raytracer/shade/sampler.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using terravox::trace::BatchMeans;

namespace {

/// What is known of the errors of many pixels, each with the same number of samples; roots of the
/// means of their squares.
struct Errors {
    double true_one = 0;
    double said = 0;
    double of_independent = 0;  ///< what the formula for independent numbers would say
};

/// @param value of a pixel's sample
Errors errors_of(const std::function<double(int pixel, std::uint32_t sample)>& value, double mean,
                 int samples) {
    constexpr int kPixels = 2048;
    Errors out;
    for (int pixel = 0; pixel < kPixels; ++pixel) {
        BatchMeans batches;
        double sum = 0;
        double squares = 0;
        for (int i = 0; i < samples; ++i) {
            const double v = value(pixel, static_cast<std::uint32_t>(i));
            batches.add(static_cast<float>(v));
            sum += v;
            squares += (v - mean) * (v - mean);
        }
        const double off = sum / samples - mean;
        out.true_one += off * off;
        out.said += batches.error() * batches.error();
        out.of_independent += squares / samples / samples;
    }
    out.true_one = std::sqrt(out.true_one / kPixels);
    out.said = std::sqrt(out.said / kPixels);
    out.of_independent = std::sqrt(out.of_independent / kPixels);
    return out;
}

}  // namespace

TEST_CASE("independent numbers have the error of independent ones", "[raytracer][trace]") {
    const auto random = [](int pixel, std::uint32_t sample) {
        return core::unit_from(
            core::hash64(static_cast<std::uint64_t>(pixel), std::uint64_t{sample}));
    };
    for (const int samples : {9, 15, 16, 17, 64, 100, 255}) {
        INFO(samples << " samples");
        const Errors errors = errors_of(random, 0.5, samples);
        CHECK(errors.said == Approx(errors.true_one).epsilon(0.06));
    }
}

TEST_CASE("spread samples have less error than independent ones, and at most what is said",
          "[raytracer][trace]") {
    struct Integrand {
        const char* name;
        double (*of)(double u, double v);
        double mean;
    };
    const auto integrand = GENERATE(
        Integrand{"smooth", [](double u, double v) { return u + v * v; }, 0.5 + 1.0 / 3},
        Integrand{"an edge", [](double u, double v) { return u < 0.3 + 0.4 * v ? 1.0 : 0.0; }, 0.5},
        Integrand{"a corner", [](double u, double v) { return u < 0.3 && v < 0.2 ? 1.0 : 0.0; },
                  0.06});
    const auto value = [&](int pixel, std::uint32_t sample) {
        const auto [u, v] = shade::Sampler(pixel, 0, sample).pair(0);
        return integrand.of(u, v);
    };
    for (const int samples : {16, 64, 256}) {
        INFO(integrand.name << ", " << samples << " samples");
        const Errors errors = errors_of(value, integrand.mean, samples);
        CHECK(errors.said > errors.true_one);
        // Batches of two cannot tell yet how evenly samples are spread.
        CHECK(errors.said < (samples > 16 ? 0.85 : 1.05) * errors.of_independent);
    }
}
