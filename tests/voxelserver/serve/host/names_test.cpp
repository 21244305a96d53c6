#include <unistd.h>
#include <array>
#include <nlohmann/json.hpp>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "voxelserver/serve/host/host_names.hpp"
#include "voxelserver/serve/host/message.hpp"

using namespace terravox::http;
using namespace terravox;

TEST_CASE("If-None-Match lists entity tags, strong or weak", "[voxelserver][http]") {
    for (const char* header : {"\"abc-1\"", "W/\"abc-1\"", "*", "\"x\", \"abc-1\"",
                               " , \"x\" ,, W/\"abc-1\"", "\"a,b\", \"abc-1\""})
        CHECK(etag_matches(header, "\"abc-1\""));
    for (const char* header : {"", "\"abc-2\"", "abc-1", "\"xabc-1\"", "\"abc-1", "W/"})
        CHECK_FALSE(etag_matches(header, "\"abc-1\""));
}

TEST_CASE("the headers say whether a request has a body", "[voxelserver][http]") {
    struct Case {
        const char* name;
        std::vector<Header> headers;
        BodyClaim::Kind kind;
        std::uint64_t bytes = 0;
    };
    const auto c = GENERATE(values<Case>({
        {"no header", {}, BodyClaim::Kind::kNone},
        {"length 0", {{"content-length", "0"}}, BodyClaim::Kind::kNone},
        {"length 3", {{"Content-Length", "3"}}, BodyClaim::Kind::kSome, 3},
        {"a length no integer holds",
         {{"Content-Length", "99999999999999999999999"}},
         BodyClaim::Kind::kSome,
         UINT64_MAX},
        {"two lengths",
         {{"Content-Length", "0"}, {"Content-Length", "5"}},
         BodyClaim::Kind::kMalformed},
        {"two lengths that agree",
         {{"Content-Length", "5"}, {"Content-Length", "5"}},
         BodyClaim::Kind::kMalformed},
        {"a length with a sign", {{"Content-Length", "+5"}}, BodyClaim::Kind::kMalformed},
        {"negative", {{"Content-Length", "-1"}}, BodyClaim::Kind::kMalformed},
        {"empty", {{"Content-Length", ""}}, BodyClaim::Kind::kMalformed},
        {"hexadecimal", {{"Content-Length", "0x5"}}, BodyClaim::Kind::kMalformed},
        {"chunked", {{"TRANSFER-ENCODING", "chunked"}}, BodyClaim::Kind::kMalformed},
        {"identity",
         {{"Transfer-Encoding", "identity"}, {"Content-Length", "0"}},
         BodyClaim::Kind::kMalformed},
    }));
    DYNAMIC_SECTION(c.name) {
        const BodyClaim claim = body_claim(Request{"GET", "/", c.headers});
        CHECK(claim.kind == c.kind);
        CHECK(claim.bytes == c.bytes);
    }
}

TEST_CASE("a problem is JSON whatever its detail holds", "[voxelserver][http]") {
    const Response r = problem(404, "no \"such\" thing\n\xff\xfe");
    const auto json = nlohmann::json::parse(*r.body);
    CHECK(json["status"] == 404);
    CHECK(json["title"] == "Not Found");
    CHECK(json["type"] == "about:blank");
    CHECK_THAT(json["detail"].get<std::string>(), terravox::test::contains("no \"such\" thing"));
    CHECK(r.header("content-type") == "application/problem+json");
}

TEST_CASE("headers are found in any case and joined in order", "[voxelserver][http]") {
    const Request r{
        "GET", "/", {{"If-None-Match", "\"a\""}, {"X", "1"}, {"if-none-match", "\"b\""}}};
    CHECK(r.header("IF-NONE-MATCH") == "\"a\", \"b\"");
    CHECK(r.header("Y").empty());
    CHECK(r.has_header("x"));
}

TEST_CASE("Accept-Encoding chooses between zstd and identity", "[voxelserver][http]") {
    const auto check = [](Coding coding, std::initializer_list<const char*> headers) {
        for (const char* header : headers) {
            INFO("'" << header << "'");
            CHECK(choose_coding(header) == coding);
        }
    };
    check(Coding::kIdentity,
          {"", "zstd;q=0", "zstd; q=0.000", "gzip", "*", "identity, *;q=0", "zstdx", ",,;;"});
    check(Coding::kZstd, {"zstd", "gzip, deflate, br, zstd", "ZSTD;q=0.5", "identity;q=0, zstd"});
    check(Coding::kNone, {"identity;q=0", "*;q=0", "gzip, *;q=0"});
}

TEST_CASE("a header's value cannot end the header", "[voxelserver][http]") {
    Response r;
    r.add("X", "a\r\nSet-Cookie: b\x7f");
    CHECK(r.head == "X: aSet-Cookie: b\r\n");
    CHECK(r.header("x") == "aSet-Cookie: b");
    CHECK(r.header("Set-Cookie").empty());
}

TEST_CASE("of a path in a message only the name at its end is shown",
          "[voxelserver][http][message]") {
    struct Case {
        const char *text, *shown;
    };
    const auto c = GENERATE(values<Case>({
        {"", ""},
        {"no path at all", "no path at all"},
        {"box 0/1/2/3: cut", "box 0/1/2/3: cut"},
        {"1/2 of it", "1/2 of it"},
        {"read /data/a.laz: cut short", "read a.laz: cut short"},
        {"read '/data/my place/a.laz': cut short", "read 'a.laz': cut short"},
        {"read /data/my place/a.laz: cut short", "read a.laz: cut short"},
        {"read /data/my place/north west/a.laz at byte 7", "read a.laz at byte 7"},
        {"decode /data/a.laz for box 0/1/2/3: cut", "decode a.laz for box 0/1/2/3: cut"},
        {"/data/a.laz", "a.laz"},
        {"/data/", "data/"},
        {"the folder / is full", "the folder  is full"},
        {"file=/etc/passwd, x", "file=passwd, x"},
        {"dlopen (/usr/lib/libgdal.so.32): not found", "dlopen (libgdal.so.32): not found"},
        {"read x:/data/a.laz", "read x:a.laz"},
        {"move /a/b, /c/d; /e/f", "move b, d; f"},
    }));
    DYNAMIC_SECTION(c.text) {
        CHECK(terravox::http::without_folders(c.text) == c.shown);
    }
}

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
