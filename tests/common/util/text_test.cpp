#include <array>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "common/util/error.hpp"
#include "common/util/json_text.hpp"
#include "common/util/text.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;
using terravox::util::printable;

namespace {

/// What bash makes of an array of a script: its words, each with a zero byte behind.
std::string read_back(const std::vector<std::string>& words) {
    const test::TemporaryFolder folder;
    const auto script = folder.path() / "script.sh";
    std::ofstream(script) << "set -euo pipefail\n"
                          << util::shell_array("words", words)
                          << "printf '%s\\0' \"${words[@]}\"\n";
    FILE* bash = ::popen(("bash --norc '" + script.string() + "'").c_str(), "r");
    REQUIRE(bash != nullptr);
    std::string out;
    std::array<char, 4096> part{};
    while (const std::size_t count = std::fread(part.data(), 1, part.size(), bash))
        out.append(part.data(), count);
    REQUIRE(::pclose(bash) == 0);
    return out;
}

std::string joined(const std::vector<std::string>& words) {
    std::string out;
    for (const std::string& word : words)
        out += word + '\0';
    return out;
}

}  // namespace

TEST_CASE("a byte of zero hides nothing of an error", "[common][util]") {
    using namespace std::string_literals;
    const terravox::util::UsageError error("read the plan of "s + "a\0b\0"s + ": it is damaged");
    CHECK(terravox::util::printable(error.what()) ==
          "read the plan of a\\x00b\\x00: it is damaged");
    CHECK(terravox::util::printable("a\0b"s) == "a\\x00b");
}

TEST_CASE("control characters become visible escapes, all other text stays",
          "[common][util][printable]") {
    struct Case {
        const char* name;
        std::string text;
        std::string shown;
    };
    for (const Case& c : {Case{"plain", "worker 7 at 10.0.0.1:7878", "worker 7 at 10.0.0.1:7878"},
                          Case{"nothing", "", ""},
                          Case{"a colour", "\x1b[31mred", "\\x1b[31mred"},
                          Case{"a title", "\x1b]0;x\x07", "\\x1b]0;x\\x07"},
                          Case{"lines", "a\r\nb\tc", "a\\r\\nb\\tc"},
                          Case{"NUL", std::string("a\0b", 3), "a\\x00b"},
                          Case{"DEL", "\x7f", "\\x7f"},
                          Case{"C1 in UTF-8",
                               "\xc2\x9b"
                               "31m",
                               "\\u009b31m"},
                          Case{"C1 as a byte",
                               "\x9b"
                               "31m",
                               "\\x9b31m"},
                          Case{"an override of direction",
                               "\xe2\x80\xae"
                               "gpj.exe",
                               "\\u202egpj.exe"},
                          Case{"an isolate", "\xe2\x81\xa6", "\\u2066"},
                          Case{"a line separator", "\xe2\x80\xa8", "\\u2028"},
                          Case{"an Arabic mark", "\xd8\x9c", "\\u061c"},
                          Case{"letters", "K\xc3\xb6ln \xe6\x9d\xb1\xe4\xba\xac \xf0\x9f\x97\xbb",
                               "K\xc3\xb6ln \xe6\x9d\xb1\xe4\xba\xac \xf0\x9f\x97\xbb"},
                          Case{"a no-break space", "\xc2\xa0", "\xc2\xa0"},
                          Case{"cut off", "\xe6\x9d", "\\xe6\\x9d"},
                          Case{"too long", "\xc0\x9b", "\\xc0\\x9b"},
                          Case{"longer than it need be", "\xe0\x82\x9b", "\\xe0\\x82\\x9b"},
                          Case{"a surrogate", "\xed\xa0\x80", "\\xed\\xa0\\x80"},
                          Case{"beyond Unicode", "\xf5\x80\x80\x80", "\\xf5\\x80\\x80\\x80"},
                          Case{"a path", "C:\\new", "C:\\new"}}) {
        INFO(c.name);
        CHECK(printable(c.text) == c.shown);
        CHECK(printable(c.shown) == c.shown);
    }
}

TEST_CASE("a word that no shell changes stays as it is, others are quoted", "[cluster][shell]") {
    CHECK(util::shell_word("frames/%04d.exr") == "frames/%04d.exr");
    CHECK(util::shell_word("") == "''");
    CHECK(util::shell_word("a b") == "'a b'");
    CHECK(util::shell_word("it's") == "'it'\\''s'");
    CHECK(util::shell_word("~") == "'~'");
    CHECK(util::shell_word("a\r\nb") == "$'a\\015\\012b'");
    CHECK_THROWS_AS(util::shell_word(std::string_view("a\0b", 3)), util::UsageError);
}

TEST_CASE("bash reads back what was written, whatever it is", "[cluster][shell]") {
    const std::vector<std::string> hostile{
        "",         " ",        "a b",   "'",         "''",
        "\"",       "\\",       "\\'",   "$HOME",     "$(touch /tmp/never)",
        "`id`",     "!!",       "*",     "?",         "[a-z]",
        "{a,b}",    "~",        "~root", "#",         "-n",
        "--",       "-e",       "a\nb",  "\n",        "\r\n",
        "\t",       "\x01",     "\x7f",  "\x1b[31m",  "Škofja Loka",
        "日本",     "\xff\xfe", "\xc3",  "a'b\nc\\d", "$'x'",
        "%s %d %%", "&& rm",    "; ls",  "> x",       "| y",
        "a=b",      "((1))",    "\\n\n", "'\x01'",    std::string(20000, '\''),
    };
    CHECK(read_back(hostile) == joined(hostile));
}

TEST_CASE("bash reads back random bytes", "[cluster][shell]") {
    const auto seed = GENERATE(1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U);
    INFO("seed " << seed);
    std::mt19937 random(seed);
    std::vector<std::string> words;
    for (int i = 0; i < 200; ++i) {
        std::string word;
        for (auto length = random() % 40; length > 0; --length)
            word += random() % 3 == 0 ? "'\"\\$`\n\r\t !*"[random() % 11]
                                      : static_cast<char>(1 + random() % 255);
        words.push_back(word);
    }
    CHECK(read_back(words) == joined(words));
    // What Slurm would refuse, or take for another line.
    for (const std::string& word : words)
        CHECK(util::shell_word(word).find_first_of("\r\n") == std::string::npos);
}

TEST_CASE("text in a comment cannot leave it", "[cluster][shell]") {
    CHECK(util::comment_text("a\nrm -rf /\r\x7f") == "a?rm -rf /??");
    CHECK(util::comment_text(std::string(101, 'x')) == std::string(100, 'x') + " ...");
}

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
