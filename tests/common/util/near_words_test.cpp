#include "common/util/text.hpp"

#include <string>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;

namespace {

const std::vector<std::string> kKnown = {"render",  "convert",  "serve",         "survey",
                                         "--ortho", "--output", "--output-size", "material"};

}  // namespace

TEST_CASE("the distance of two texts counts the edits between them", "[common][util][near_words]") {
    CHECK(util::edit_distance("kitten", "sitting") == 3);
    CHECK(util::edit_distance("", "abc") == 3);
    CHECK(util::edit_distance("abc", "abc") == 0);
    CHECK(util::edit_distance("abc", "acb") == 1);
    CHECK(util::edit_distance("ca", "abc") == 3);  // no byte is changed twice
}

TEST_CASE("a mistyped word is near the one that was meant", "[common][util][near_words]") {
    struct Case {
        const char* name;
        const char* mistyped;
        std::vector<std::string> near;
    };
    const auto c = GENERATE(values<Case>({
        {"a letter left out", "rendr", {"render"}},
        {"a letter too many", "rennder", {"render"}},
        {"another letter", "sender", {"render"}},
        {"neighbours swapped", "--otrho", {"--ortho"}},
        {"capital letters", "Render", {"render"}},
        {"one hyphen", "-ortho", {"--ortho"}},
        {"no hyphen", "output", {"--output"}},
        {"a short form", "--out", {"--output"}},
        {"the beginning of a long word", "mater", {"material"}},
        {"the beginning of too short a word", "ma", {}},
        {"two equally near", "serv", {"serve"}},
        {"as near to two", "surve", {"serve", "survey"}},
        {"three letters of a short word", "sky", {}},
        {"nothing alike", "--frobnicate", {}},
        {"nothing", "", {}},
        {"hyphens alone", "--", {}},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK(util::near_words(c.mistyped, kKnown) == c.near);
    }
}

TEST_CASE("a message names what was meant and what is allowed", "[common][util][near_words]") {
    const std::vector<std::string> known = {"serve", "survey"};
    CHECK(util::did_you_mean("surve", known) == "; did you mean serve or survey?");
    CHECK(util::did_you_mean("survei", known) == "; did you mean survey?");
    CHECK(util::did_you_mean("paint", known).empty());
    CHECK(util::allowed_words("survei", known) == "; did you mean survey? allowed: serve, survey");
    CHECK(util::allowed_words("paint", known) == "; allowed: serve, survey");
}
