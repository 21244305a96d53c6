#include "voxelserver/serve/sockets/socket.hpp"

#include "common/util/error.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using sockets::Address;
using terravox::test::contains;

TEST_CASE("addresses are read", "[sockets][address]") {
    struct Case {
        const char* text;
        std::uint16_t default_port;
        const char* host;
        std::uint16_t port;
        const char* back;
    };
    for (const Case c : {Case{"node7:7878", 0, "node7", 7878, "node7:7878"},
                         Case{"node7", 7879, "node7", 7879, "node7:7879"},
                         Case{":0", 0, "", 0, ":0"}, Case{":7878", 1, "", 7878, ":7878"},
                         Case{"192.0.2.7:65535", 1, "192.0.2.7", 65535, "192.0.2.7:65535"},
                         Case{"[2001:db8::1]:80", 1, "2001:db8::1", 80, "[2001:db8::1]:80"},
                         Case{"[::1]", 5, "::1", 5, "[::1]:5"},
                         Case{"a-b.example.org", 9, "a-b.example.org", 9, "a-b.example.org:9"}}) {
        INFO(c.text);
        const sockets::Address address = sockets::Address::parse(c.text, c.default_port);
        CHECK(address.host == c.host);
        CHECK(address.port == c.port);
        CHECK(address.text() == c.back);
    }
}

TEST_CASE("text that is no address is refused", "[sockets][address]") {
    struct Case {
        const char* text;
        std::uint16_t default_port;
        const char* why;
    };
    for (const Case c :
         {Case{"", 7878, "empty"}, Case{"node7", 0, "no port"}, Case{"node7:", 1, "'' is no port"},
          Case{"node7:65536", 1, "'65536' is no port"}, Case{"node7:-1", 1, "'-1'"},
          Case{"node7:80x", 1, "'80x'"}, Case{"node7: 80", 1, "' 80'"}, Case{"::1", 1, "brackets"},
          Case{"::1:80", 1, "brackets"}, Case{"[::1", 1, "no ']'"}, Case{"[::1]80", 1, "after ']'"},
          Case{"[node7]:80", 1, "no IPv6"}, Case{"http://node7", 1, "no port"},
          Case{"a/b:80", 1, "character"}, Case{"u@node7:80", 1, "character"}}) {
        INFO(c.text);
        CHECK_THROWS_AS(sockets::Address::parse(c.text, c.default_port), util::UsageError);
        CHECK_THROWS_WITH(
            sockets::Address::parse(c.text, c.default_port),
            contains(c.why) && contains("HOST:PORT") && contains("'" + std::string(c.text) + "'"));
    }
}

TEST_CASE("a peer has one name, however it is obtained", "[sockets][address]") {
    const auto only = [](const char* host) {
        return sockets::resolve({.host = host, .port = 51234}, false).front();
    };
    CHECK(only("192.0.2.7").text() == "192.0.2.7:51234");
    CHECK(only("::ffff:192.0.2.7").text() == "192.0.2.7:51234");
    CHECK(only("2001:db8::1").text() == "[2001:db8::1]:51234");
    CHECK(only("::ffff:192.0.2.7").neighbourhood() == "192.0.2.7");
    CHECK(only("2001:db8:1:2:3:4:5:6").neighbourhood() == only("2001:db8:1:2::9").neighbourhood());
    CHECK(only("2001:db8:1:2::9").neighbourhood() != only("2001:db8:1:3::9").neighbourhood());
    for (const char* host : {"192.0.2.7", "::ffff:192.0.2.7", "2001:db8:1:2:3:4:5:6"})
        CHECK(sockets::to_neighbourhood(only(host).text()) == only(host).neighbourhood());
    CHECK(sockets::to_neighbourhood("pair:1") == "pair");
    CHECK(sockets::to_neighbourhood("[nonsense]:1") == "[nonsense]");
}

TEST_CASE("an unknown host name is an error of its own", "[sockets][address]") {
    CHECK_THROWS_WITH(sockets::resolve({.host = "no-such-host.invalid", .port = 1}, false),
                      contains("look up no-such-host.invalid"));
}
