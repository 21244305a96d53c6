#include "common/util/text.hpp"

#include <limits>

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

TEST_CASE("a number's text is the shortest that reads back as it", "[common][util][text]") {
    using namespace terravox::util;
    CHECK(number_text(0.1) == "0.1");
    CHECK(number_text(0.1F) == "0.1");
    CHECK(number_text(100000.0) == "1e+05");
    CHECK(number_text(1.0 / 3) == "0.3333333333333333");
    CHECK(number_text(-std::numeric_limits<double>::denorm_min()) == "-5e-324");
    CHECK(number_text(1.0 / 3, 6) == "0.333333");
    CHECK(number_text(1234567.0, 6) == "1.23457e+06");
    CHECK(number_text(2.0, 15) == "2");
    CHECK(number_text(std::numeric_limits<double>::infinity(), 15) == "inf");
    CHECK(plain_number_text(100000.0) == "100000");
    CHECK(plain_number_text(1e-7) == "0.0000001");
    CHECK(plain_number_text(1e-300) == "1e-300");
}
