#include "common/util/text.hpp"

#include <string>

#include "common/util/error.hpp"
#include "tests/catch.hpp"

using terravox::util::printable;

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
