#include "raytracer/farm/net/token_strength.hpp"

#include "raytracer/farm/net/token.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using terravox::test::contains;

TEST_CASE("tokens that people think of are refused, and those of generators are not",
          "[common][net][token]") {
    struct Case {
        const char* token;
        bool good;
    };
    for (const Case& c :
         {Case{"aaaaaaaaaaaaaaaaaaaaaaaa", false}, Case{"0123456789abcdef", false},
          Case{"abababababababababab", false}, Case{"passwordpassword", false},
          Case{"P@ssw0rdP@ssw0rd123", false}, Case{"qwertyuiopasdfghjkl", false},
          Case{"terravox-farm-2024", false}, Case{"MyFarmToken12345!", false},
          Case{"a token of the tests", false}, Case{"a-token-of-the-tests-1234", false},
          Case{"ThisIsOurRenderFarm2026", false}, Case{"Liverpool-Chelsea-2019", false},
          Case{"correcthorsebatterystaple", false},
          Case{"0000000000000000000000000000000000000000", false},
          Case{"9f86d081884c7d659a2feaa0c55ad015", true},
          Case{"f81d4fae-7dec-11d0-a765-00a0c91e6bf6", true}, Case{"u7Zr0QmX1bKf9TqLw3VdYg", true},
          Case{"kv7r2mx9q4tz8wpd5hcn", true},
          Case{"vivid-anchor-mosquito-plank-drizzle-hexagon", true}}) {
        INFO(c.token << ": " << net::estimated_bits(c.token) << " bits");
        CHECK(net::weakness_of(c.token).empty() == c.good);
    }
    CHECK_THAT(net::weakness_of("short"),
               contains("5 characters; allowed: at least 16") && contains("openssl rand -hex 16"));
    CHECK_THAT(net::weakness_of("passwordpassword"), contains("can be guessed") &&
                                                         contains("at least 64 bits") &&
                                                         contains("terravox worker"));
    CHECK(net::estimated_bits("") == 0);
    for (int i = 0; i < 100; ++i)
        CHECK(net::weakness_of(net::new_token()).empty());
}

TEST_CASE("a token gets no weaker by more characters, and no stronger by repeating itself",
          "[common][net][token]") {
    const std::string token = "9f86d081884c7d65";
    double before = 0;
    for (std::size_t length = 1; length <= token.size(); ++length) {
        const double bits = net::estimated_bits(token.substr(0, length));
        CHECK(bits >= before);
        before = bits;
    }
    CHECK(net::estimated_bits(token + token + token) < before + 0.1 * before + 5);
}
