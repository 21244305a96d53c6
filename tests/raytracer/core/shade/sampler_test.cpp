#include "raytracer/core/shade/sampler.hpp"

#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE("dimensions of the Sobol' sequence are the published ones",
          "[raytracer][shade][sampler]") {
    // The first eight points, which are published in the order of Gray codes. Ref: Joe and Kuo,
    // new-joe-kuo-6.
    const std::array<std::array<double, 3>, 8> points{{{0, 0, 0},
                                                       {0.5, 0.5, 0.5},
                                                       {0.25, 0.25, 0.25},
                                                       {0.75, 0.75, 0.75},
                                                       {0.375, 0.625, 0.875},
                                                       {0.875, 0.125, 0.375},
                                                       {0.125, 0.875, 0.625},
                                                       {0.625, 0.375, 0.125}}};
    constexpr double kUnit = 0x1.0p-32;
    for (std::uint32_t i = 0; i < 8; ++i) {
        const std::uint32_t gray = i ^ i >> 1;
        INFO("point " << i);
        CHECK(shade::sobol_number<1>(gray) * kUnit == points[i][0]);
        CHECK(shade::sobol_number<2>(gray) * kUnit == points[i][1]);
        CHECK(shade::sobol_number<3>(gray) * kUnit == points[i][2]);
    }
}

TEST_CASE("samples of a pixel lie one in each cell of every elementary interval",
          "[raytracer][shade][sampler]") {
    for (const std::uint32_t dimension : {0u, 1u, 77u, 0xffff0000u})
        for (int pixel = 0; pixel < 20; ++pixel)
            for (int log2_count = 0; log2_count <= 8; ++log2_count) {
                const int count = 1 << log2_count;
                for (int log2_columns = 0; log2_columns <= log2_count; ++log2_columns) {
                    const int columns = 1 << log2_columns;
                    const int rows = count / columns;
                    std::set<int> seen;
                    for (int s = 0; s < count; ++s) {
                        const auto at =
                            shade::Sampler(pixel * 37, pixel, static_cast<std::uint32_t>(s))
                                .pair(dimension);
                        REQUIRE((at.u >= 0 && at.u < 1 && at.v >= 0 && at.v < 1));
                        seen.insert(static_cast<int>(at.u * columns) * rows +
                                    static_cast<int>(at.v * rows));
                    }
                    INFO("pixel " << pixel << ", dimension " << dimension << ", " << columns
                                  << " x " << rows);
                    REQUIRE(seen.size() == static_cast<std::size_t>(count));
                }
            }
}

namespace {

using Numbers = std::array<double, 4>;

/// The point of the pixel, and what its ray's end has from across_pixel().
Numbers joint_numbers(int pixel, std::uint32_t sample) {
    const shade::Sampler numbers(pixel, 11, sample);
    const auto point = numbers.in_pixel();
    const auto direction = numbers.across_pixel(3);
    return {point.u, point.v, direction.u, direction.v};
}

}  // namespace

TEST_CASE("each number across a pixel is evenly spread at every power of two",
          "[raytracer][shade][sampler]") {
    for (int pixel = 0; pixel < 50; ++pixel)
        for (std::uint32_t count = 1; count <= 1024; count *= 2) {
            std::array<std::set<int>, 4> seen;
            for (std::uint32_t s = 0; s < count; ++s) {
                const Numbers numbers = joint_numbers(pixel, s);
                for (std::size_t i = 0; i < numbers.size(); ++i)
                    seen[i].insert(static_cast<int>(numbers[i] * count));
            }
            INFO("pixel " << pixel << ", " << count << " samples");
            for (const auto& cells : seen)
                REQUIRE(cells.size() == count);
        }
}

TEST_CASE("dimensions and pixels are independent of each other", "[raytracer][shade][sampler]") {
    // Pairs of numbers of two dimensions fill the square; of uniform independent ones chi squared
    // over 64 cells is 63 +- 11.
    const auto chi2 = [](const auto& first, const auto& second) {
        std::vector<double> cells(64);
        constexpr int kCount = 6400;
        for (int i = 0; i < kCount; ++i)
            cells[static_cast<std::size_t>(static_cast<int>(first(i) * 8) * 8 +
                                           static_cast<int>(second(i) * 8))] += 1;
        double sum = 0;
        for (const double c : cells)
            sum += (c - 100) * (c - 100) / 100;
        return sum;
    };
    const auto across = [](std::uint32_t dimension) {
        return [dimension](int i) { return shade::Sampler(i % 80, i / 80, 5).number(dimension); };
    };
    CHECK(chi2(across(1), across(2)) < 130);
    CHECK(chi2(across(1), [](int i) { return shade::Sampler(i % 80 + 1, i / 80, 5).number(1); }) <
          130);
    const auto along = [](std::uint32_t dimension) {
        return [dimension](int i) {
            return shade::Sampler(3, 4, static_cast<std::uint32_t>(i)).pair(dimension).u;
        };
    };
    CHECK(chi2(along(1), along(2)) < 130);
}
