#include "common/util/utf8.hpp"

#include "tests/catch.hpp"

using terravox::util::broken_lines;
using terravox::util::first_character;

TEST_CASE("characters are read as UTF-8, and what is not is marked", "[common][util]") {
    CHECK(first_character("ač").code == U'a');
    CHECK(first_character("ča").code == U'č');
    CHECK(first_character("ča").bytes == 2);
    CHECK(first_character("€").bytes == 3);
    CHECK(first_character("\xf0\x9f\x98\x80").code == U'\U0001f600');
    for (const char* bad :
         {"\xff", "\xc3", "\x80", "\xc0\x80", "\xed\xa0\x80", "\xf8\x88\x80\x80\x80", "\xe2\x82"})
        CHECK(first_character(bad).bytes == 0);
}

TEST_CASE("characters are written as they are read", "[common][util]") {
    for (const char32_t code :
         {U'\1', U'\x7f', U'\x80', U'\x7ff', U'\x800', U'\xffff', U'\U00010000', U'\U0010ffff'}) {
        std::string text;
        terravox::util::append_utf8(text, code);
        CHECK(first_character(text).code == code);
        CHECK(first_character(text).bytes == text.size());
    }
}

TEST_CASE("lines are broken at spaces, else within a word, and never within a character",
          "[common][util]") {
    struct Case {
        const char* name;
        const char* text;
        std::vector<std::string> lines;
    };
    for (const Case& c :
         {Case{"nothing", "", {}}, Case{"spaces", "   ", {}}, Case{"a short one", " abc", {"abc"}},
          Case{"words", "ab cde fg hijk", {"ab", "cde", "fg", "hijk"}},
          Case{"two words in a line", "a b c d e", {"a b", "c d", "e"}},
          Case{"a space at the end of a line", "abcd ef", {"abcd", "ef"}},
          Case{"a long word", "abcdefghij k", {"abcd", "efgh", "ij k"}},
          Case{"letters of two bytes", "ččč", {"čč", "č"}},
          Case{"a letter that fits nowhere",
               "\xf0\x9f\x98\x80"
               "a",
               {"\xf0\x9f\x98\x80", "a"}},
          Case{"bytes that are no text", "\xff\xff\xff\xff\xff", {"\xff\xff\xff\xff", "\xff"}}}) {
        INFO(c.name);
        CHECK(broken_lines(c.text, [](const std::string& line) { return line.size() <= 4; }) ==
              c.lines);
    }
}
