#include "common/util/text.hpp"

#include <array>
#include <cstdio>
#include <fstream>
#include <random>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;

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
