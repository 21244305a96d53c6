#include "common/util/json_text.hpp"

#include <nlohmann/json.hpp>
#include <string>

#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE("levels of JSON are counted, brackets in strings are not", "[common][util]") {
    struct Case {
        const char* text;
        int levels;
    };
    const auto c = GENERATE(values<Case>({
        {"", 0},
        {"1", 0},
        {"[]", 1},
        {"[[],[],{}]", 2},
        {R"({"a":[1,{"b":[]}],"c":{}})", 4},
        {R"(["[[[["])", 1},
        {R"(["\"[[[[", {}])", 2},
        {R"(["\\", [[]]])", 3},
        {R"(["\\\"[", []])", 2},
        {R"({"[{":"}]"})", 1},
        // No JSON.
        {"]]][", 0},
        {"[[[", 3},
        {"[\"\\", 1},
    }));
    CAPTURE(c.text);
    CHECK_FALSE(util::has_more_json_levels(c.text, c.levels));
    if (c.levels > 0)
        CHECK(util::has_more_json_levels(c.text, c.levels - 1));
}

TEST_CASE("JSON of too many levels is discarded as what is none", "[common][util]") {
    const auto nested = [](std::size_t levels) {
        return std::string(levels, '[') + std::string(levels, ']');
    };
    CHECK(util::parse_json(R"({"a": [1, "\u0041"]})") ==
          nlohmann::json{{"a", nlohmann::json::array({1, "A"})}});
    CHECK(util::parse_json(nested(util::kMaxJsonLevels)).is_array());
    CHECK(util::parse_json(nested(util::kMaxJsonLevels + 1)).is_discarded());
    CHECK(util::parse_json(nested(3), 3).is_array());
    CHECK(util::parse_json(nested(3), 2).is_discarded());
    for (const char* const text : {"", "{", "[1,]", "nul", "[1] 2", "\"\xff\""}) {
        CAPTURE(text);
        CHECK(util::parse_json(text).is_discarded());
    }
}
