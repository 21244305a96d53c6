#include "common/util/text.hpp"

#include "common/util/error.hpp"
#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE("a range is one number or two", "[util][range]") {
    CHECK(util::parse_range("--frames", "4-9", {0, 9}) == util::IntRange{4, 9});
    CHECK(util::parse_range("--frames", "0", {0, 9}) == util::IntRange{0, 0});
    const auto wrong =
        GENERATE(values<std::string>({"", "-", "4-", "-4", "9-4", "4-10", "x", "4-9x", "4 9",
                                      "99999999999", "4-99999999999", "1.5", "0x3", "4--9", "+4"}));
    DYNAMIC_SECTION("not '" << wrong << "'") {
        CHECK_THROWS_AS(util::parse_range("--frames", wrong, {0, 9}), util::UsageError);
        CHECK_THROWS_WITH(util::parse_range("--frames", wrong, {0, 9}),
                          test::contains("from 0 to 9"));
    }
}
