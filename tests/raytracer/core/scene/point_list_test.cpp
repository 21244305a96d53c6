#include "raytracer/core/scene/scene.hpp"

#include "tests/catch.hpp"

using terravox::scene::PointList;

TEST_CASE("points survive being written and read to the last bit", "[raytracer][scene]") {
    const PointList points{{{462345.125, 0.1, -101000.0 / 3}, {-1e9, 1e-300, 0}}};
    const auto read = PointList::parse(points.text());
    REQUIRE(read);
    CHECK(*read == points);
    CHECK(PointList::parse("")->points.empty());
    CHECK(PointList{}.text().empty());
}

TEST_CASE("what is no list of points is refused", "[raytracer][scene]") {
    for (const char* text : {"1", "1,2", "1,2,3,4", "1,2,3;", ";1,2,3", "1,2,3;4,5", "1,2,x",
                             "1,2,3 ", "nan,2,3", "1,2,inf", "1,2,2e9", "1;2;3", ","}) {
        INFO(text);
        CHECK_FALSE(PointList::parse(text));
    }
}

TEST_CASE("a list of points is bounded", "[raytracer][scene]") {
    std::string text = "1,2,3";
    for (std::size_t i = 1; i < PointList::kMaxPoints; ++i)
        text += ";1,2,3";
    CHECK(PointList::parse(text)->points.size() == PointList::kMaxPoints);
    CHECK_FALSE(PointList::parse(text + ";1,2,3"));
}
