#include "voxelserver/serve/host/host_names.hpp"

#include <unistd.h>

#include <array>

#include "common/util/error.hpp"
#include "tests/catch.hpp"

using namespace terravox;

TEST_CASE(
    "a server answers to localhost, numeric addresses and the names it was given, with any port",
    "[voxelserver][http][host]") {
    const http::HostNames names("127.0.0.1", {"Voxels.Example.org"});
    for (const char* host : {"localhost", "localhost:8888", "LocalHost:1", "localhost:",
                             "127.0.0.1", "127.0.0.1:8888", "[::1]", "[::1]:8888", "192.0.2.7:80",
                             "[2001:db8::1]:80", "voxels.example.org", "VOXELS.example.org:443"}) {
        INFO(host);
        CHECK(names.allow(host));
    }
    for (const char* host : {"",
                             "attacker.example",
                             "attacker.example:8888",
                             "localhost.attacker.example",
                             "xlocalhost",
                             "127.0.0.1.attacker.example",
                             "localhost@attacker.example",
                             "localhost:x",
                             "localhost:8888:1",
                             "localhost:123456",
                             "::1",
                             "[::1",
                             "[::1]x",
                             "[attacker.example]",
                             "[127.0.0.1]",
                             "127.1",
                             "0x7f000001",
                             "localhost, localhost",
                             "a\r\nb",
                             "voxels.example.org.",
                             " localhost"}) {
        INFO("'" << host << "'");
        CHECK_FALSE(names.allow(host));
    }
    CHECK_FALSE(names.allow("[" + std::string(100, ':') + "]"));
}

TEST_CASE("the machine's own name counts where other machines may connect, and not on loopback",
          "[voxelserver][http][host]") {
    std::array<char, 256> own{};
    REQUIRE(gethostname(own.data(), own.size() - 1) == 0);
    for (const char* bind : {"0.0.0.0", "192.0.2.7", "::", ""}) {
        INFO(bind);
        CHECK(http::HostNames(bind).allow(own.data()));
        CHECK_FALSE(http::HostNames(bind).allow("attacker.example"));
    }
    if (std::string(own.data()) != "localhost")
        for (const char* bind : {"127.0.0.1", "127.8.8.8", "::1"})
            CHECK_FALSE(http::HostNames(bind).allow(own.data()));
}

TEST_CASE("what is no host name is refused when it is given", "[voxelserver][http][host]") {
    const std::string name =
        GENERATE("", "a b", "http://x", "x:80", "x/", "*", ".x", "[::1]", "x\n");
    INFO(name);
    CHECK_THROWS_AS(http::HostNames("127.0.0.1", {name}), util::UsageError);
    CHECK_THROWS_AS(http::HostNames("127.0.0.1", {std::string(254, 'x')}), util::UsageError);
}

TEST_CASE("loopback is 127.0.0.0/8 and ::1", "[voxelserver][http][host]") {
    for (const char* address : {"127.0.0.1", "127.255.0.9", "::1"})
        CHECK(http::is_loopback(address));
    for (const char* address :
         {"", "0.0.0.0", "::", "128.0.0.1", "localhost", "127.0.0.1x", "127.0.0.1.example"})
        CHECK_FALSE(http::is_loopback(address));
}

TEST_CASE("pages of other origins are known by what their browsers say",
          "[voxelserver][http][host]") {
    struct Page {
        std::string_view host, origin, site, mode, destination;
        std::string_view method = "GET";
    };
    struct Case {
        const char* name;
        Page page;
        bool foreign;
    };
    const auto c = GENERATE(values<Case>({
        {"a program", {"localhost:8888", "", "", "", ""}, false},
        {"the page itself", {"localhost:8888", "", "same-origin", "cors", "empty"}, false},
        {"the page itself, a POST",
         {"localhost:8888", "http://localhost:8888", "same-origin", "cors", "empty"},
         false},
        {"behind a front with TLS",
         {"Voxels.example.org", "https://voxels.example.org", "same-origin", "cors", "empty"},
         false},
        {"typed by the user", {"localhost:8888", "", "none", "navigate", "document"}, false},
        {"a link on another page",
         {"localhost:8888", "", "cross-site", "navigate", "document"},
         false},
        {"a form on another page, in a browser that sends no Origin",
         {"localhost:8888", "", "cross-site", "navigate", "document", "POST"},
         true},
        {"a form of the page itself",
         {"localhost:8888", "", "same-origin", "navigate", "document", "POST"},
         false},
        {"a picture in another page",
         {"localhost:8888", "", "cross-site", "no-cors", "image"},
         true},
        {"a frame in another page",
         {"localhost:8888", "", "cross-site", "navigate", "iframe"},
         true},
        {"a page of another port", {"localhost:8888", "", "same-site", "no-cors", "empty"}, true},
        {"a script elsewhere", {"localhost:8888", "http://attacker.example", "", "", ""}, true},
        {"another port", {"localhost:8888", "http://localhost:3000", "", "", ""}, true},
        {"a form elsewhere",
         {"localhost:8888", "http://attacker.example", "cross-site", "navigate", "document"},
         true},
        {"a file", {"localhost:8888", "null", "cross-site", "cors", "empty"}, true},
        {"no Host, but an origin", {"", "http://attacker.example", "", "", ""}, true},
        {"a word not known", {"localhost:8888", "", "sideways", "cors", "empty"}, true},
    }));
    DYNAMIC_SECTION(c.name) {
        http::Request request{c.page.method, "/", {}};
        for (const http::Header& header :
             std::vector<http::Header>{{"Host", c.page.host},
                                       {"Origin", c.page.origin},
                                       {"Sec-Fetch-Site", c.page.site},
                                       {"Sec-Fetch-Mode", c.page.mode},
                                       {"Sec-Fetch-Dest", c.page.destination}})
            if (!header.value.empty())
                request.headers.push_back(header);
        CHECK(http::from_another_origin(request) == c.foreign);
    }
}
