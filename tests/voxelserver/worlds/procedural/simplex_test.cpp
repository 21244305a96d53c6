#include "voxelserver/worlds/procedural/simplex.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <functional>

#include "tests/catch.hpp"
#include "voxelserver/worlds/procedural/hash.hpp"

using namespace terravox::procedural;

namespace {

double two(double x, double y, double) {
    return simplex(7, x, y);
}
double three(double x, double y, double z) {
    return simplex(7, x, y, z);
}

struct Kind {
    const char* name;
    double (*noise)(double, double, double);
};
const auto kKinds = {Kind{"two coordinates", two}, Kind{"three coordinates", three}};

// The i-th of many places, some far off.
double coordinate(int i, int part) {
    return (unit_of(mix(static_cast<std::uint64_t>(i)), part) - 0.5) * (i % 2 == 0 ? 100.0 : 1e7);
}

}  // namespace

TEST_CASE("simplex noise fills [-1, 1] and has no drift", "[raytracer][generated]") {
    for (const Kind& kind : kKinds) {
        INFO(kind.name);
        constexpr int kPlaces = 400'000;
        double low = 0;
        double high = 0;
        double sum = 0;
        for (int i = 0; i < kPlaces; ++i) {
            const double n = kind.noise(coordinate(i, 0), coordinate(i, 1), coordinate(i, 2));
            low = std::min(low, n);
            high = std::max(high, n);
            sum += n;
        }
        CHECK(low >= -1);
        CHECK(high <= 1);
        CHECK(low < -0.85);
        CHECK(high > 0.85);
        CHECK(std::abs(sum / kPlaces) < 0.005);
    }
}

TEST_CASE("simplex noise has no step", "[raytracer][generated]") {
    for (const Kind& kind : kKinds) {
        constexpr double kStep = 1e-4;
        constexpr double kSteepest = 12;
        for (int i = 0; i < 100'000; ++i) {
            const double x = coordinate(i, 0);
            const double y = coordinate(i, 1);
            const double z = coordinate(i, 2);
            const double change =
                std::abs(kind.noise(x + kStep, y - kStep, z + kStep) - kind.noise(x, y, z));
            if (change > kSteepest * kStep)
                FAIL_CHECK(kind.name << " changes by " << change << " at " << x << ", " << y << ", "
                                     << z);
        }
    }
}

TEST_CASE("simplex noise does not repeat and differs from seed to seed", "[raytracer][generated]") {
    const auto alike = [](const std::function<double(int)>& a,
                          const std::function<double(int)>& b) {
        double ab = 0;
        double aa = 0;
        double bb = 0;
        for (int i = 0; i < 20'000; ++i) {
            ab += a(i) * b(i);
            aa += a(i) * a(i);
            bb += b(i) * b(i);
        }
        return std::abs(ab) / std::sqrt(aa * bb);
    };
    const auto here = [](int i) { return simplex(1, i * 0.37, i * 0.11); };
    CHECK(alike(here, here) == Approx(1));
    CHECK(alike(here, [](int i) { return simplex(2, i * 0.37, i * 0.11); }) < 0.05);
    for (const double away : {256.0, 289.0, 65536.0, 4294967296.0})
        CHECK(alike(here, [away](int i) { return simplex(1, i * 0.37 + away, i * 0.11); }) < 0.05);
}

TEST_CASE("simplex noise has the same bits on every machine", "[raytracer][generated]") {
    CHECK(std::bit_cast<std::uint64_t>(simplex(1, 0.25, 0.75)) == 0xBFCBB9934FF360BAULL);
    CHECK(std::bit_cast<std::uint64_t>(simplex(1, -1234.5, 98765.4321)) == 0xBFD65D4FBEED82EAULL);
    CHECK(std::bit_cast<std::uint64_t>(simplex(0xFFFF'FFFF'FFFF'FFFFULL, 3.5, -0.125, 1e6 + 0.3)) ==
          0x3FDDAFD95783C261ULL);
}
