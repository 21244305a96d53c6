#include "voxelserver/data/imagery/brightness.hpp"

#include <cmath>
#include <limits>

#include "tests/catch.hpp"

using namespace terravox;
using imagery::assume_brightness;
using imagery::Brightness;
using imagery::find_range;

TEST_CASE("the depth of values is found from the brightest", "[voxelserver][imagery][bands]") {
    struct Case {
        double high;
        bool whole_numbers;
        double white;
        const char* what;
        bool is_doubtful;
    };
    const auto c = GENERATE(values<Case>({
        {0, true, 255, "8 bits", false},
        {200, true, 255, "8 bits", false},
        {255, true, 255, "8 bits", false},
        {256, true, 1023, "10 bits", true},
        {2047, true, 2047, "11 bits", true},
        {2048, true, 4095, "12 bits", true},
        {4096, true, 10000, "reflectance in parts of 10000", true},
        {10001, true, 16383, "14 bits", true},
        {16384, true, 65535, "16 bits", false},
        {65535, true, 65535, "16 bits", false},
        {70000, true, 70000, "no known depth", true},
        {0.3, false, 1, "parts of 1", false},
        {1.2, false, 1, "parts of 1", false},
        {1.9, false, 1, "parts of 1", true},
        {3, false, 255, "0 to 255", true},
        {63, false, 255, "0 to 255", true},
        {255, false, 255, "0 to 255", false},
        {3000, false, 4095, "12 bits", true},
    }));
    INFO(c.high << (c.whole_numbers ? ", whole numbers" : ""));
    const imagery::Assumption found = assume_brightness({0, c.high}, c.whole_numbers);
    CHECK(found.white == c.white);
    CHECK(found.what == c.what);
    CHECK(found.is_doubtful == c.is_doubtful);
    CHECK(found.brightness.of(found.white) == 255);
    CHECK(found.brightness.of(0) == 0);
    CHECK(found.brightness.of(-1) == 0);
    CHECK(found.brightness.of(std::nan("")) == 0);
    CHECK(found.brightness.of(10 * found.white) == 255);
}

TEST_CASE("values far below black are doubtful", "[voxelserver][imagery][bands]") {
    CHECK(!assume_brightness({-0.01, 0.5}, false).is_doubtful);
    CHECK(assume_brightness({-1, 0.5}, false).is_doubtful);
    CHECK(assume_brightness({-9999, 200}, true).is_doubtful);
}

TEST_CASE("few bits are spread, many are cut, and 0 may be white",
          "[voxelserver][imagery][bands]") {
    CHECK(Brightness::of_bits(1).of(1) == 255);
    CHECK(Brightness::of_bits(4).of(5) == 85);
    CHECK(Brightness::of_bits(8).of(77) == 77);
    CHECK(Brightness::of_bits(12).of(3200) == 200);
    CHECK(Brightness::of_bits(16).of(200 * 257) == 200);
    CHECK(Brightness::of_bits(16).inverted().of(0) == 255);
    CHECK(Brightness::of_bits(16).inverted().of(65535) == 0);
    CHECK(Brightness::of_white(1).of_scaled(0.0001, -0.1).of(6000) == 128);
    // Of 0 is white, with an offset: 6000 is half as bright as white.
    CHECK(Brightness::of_white(1).inverted().of_scaled(0.0001, -0.1).of(6000) == 128);
    CHECK(Brightness::of_white(1).inverted().of_scaled(0.0001, -0.1).of(1000) == 255);
}

TEST_CASE("a range leaves out what is no brightness", "[voxelserver][imagery][bands]") {
    std::vector<float> values(5000, 640.0F);
    values.resize(10000, 3200.0F);
    const auto high = [](std::vector<float> v) { return find_range(std::move(v), 65535).high; };
    CHECK(high(values) == 3200);
    values[7] = 60000;  // fewer than one in a thousand
    values.resize(20000, 0.0F);
    CHECK(high(values) == 3200);
    values.resize(25000, 65535.0F);
    values.push_back(std::numeric_limits<float>::quiet_NaN());
    values.push_back(std::numeric_limits<float>::infinity());
    CHECK(high(values) == 3200);
    CHECK(high(std::vector<float>(100, 65535.0F)) == 65535);
    CHECK(high(std::vector<float>(100, 0.0F)) == 0);
    CHECK(high({}) == 0);
    CHECK(find_range({-5.0F, 2.0F}, 0).low == -5);
}
