#include "common/util/linear_light.hpp"

#include <cmath>

#include "tests/catch.hpp"

using namespace terravox::util;

TEST_CASE("every sRGB value comes back from linear light", "[map][linear]") {
    for (int v = 0; v < 256; ++v)
        CHECK(to_srgb(to_linear(static_cast<std::uint8_t>(v))) == v);
    CHECK(to_linear(0) == 0);
    CHECK(to_linear(255) == kBrightest);
    CHECK(to_srgb(kBrightest + 1) == 255);
    CHECK(to_srgb(0xffffffffU) == 255);
}

TEST_CASE("linear light becomes the nearest sRGB value", "[map][linear]") {
    int wrong = 0;
    int last = 0;
    for (std::uint32_t linear = 0; linear <= kBrightest; ++linear) {
        const double c = linear / 65535.0;
        const double exact =
            255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055);
        const int value = to_srgb(linear);
        wrong += std::abs(value - exact) > 0.53 || value < last ? 1 : 0;
        last = value;
    }
    CHECK(wrong == 0);
}
