#include "voxelserver/serve/host/message.hpp"

#include <nlohmann/json.hpp>

#include "tests/catch.hpp"

using namespace terravox::http;

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
