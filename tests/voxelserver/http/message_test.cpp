#include "voxelserver/http/message.hpp"

#include <nlohmann/json.hpp>

#include "tests/catch.hpp"

using namespace terravox::http;

TEST_CASE("If-None-Match lists entity tags, strong or weak", "[voxelserver][http]") {
    struct Case {
        const char *name, *header;
        bool matches;
    };
    const auto c = GENERATE(values<Case>({
        {"nothing sent", "", false},
        {"the tag", "\"abc-1\"", true},
        {"the tag, weak", "W/\"abc-1\"", true},
        {"another tag", "\"abc-2\"", false},
        {"anything", "*", true},
        {"second of a list", "\"x\", \"abc-1\"", true},
        {"a list with holes", " , \"x\" ,, W/\"abc-1\"", true},
        {"the tag without quotes", "abc-1", false},
        {"the tag as part of another", "\"xabc-1\"", false},
        {"an open quote", "\"abc-1", false},
        {"a lone W/", "W/", false},
        {"a comma in a tag", "\"a,b\", \"abc-1\"", true},
    }));
    DYNAMIC_SECTION(c.name) { CHECK(etag_matches(c.header, "\"abc-1\"") == c.matches); }
}

TEST_CASE("the headers say whether a request has a body", "[voxelserver][http]") {
    struct Case {
        const char* name;
        std::vector<Header> headers;
        BodyClaim claim;
    };
    const auto c = GENERATE(values<Case>({
        {"no header", {}, BodyClaim::kNone},
        {"length 0", {{"content-length", "0"}}, BodyClaim::kNone},
        {"length 3", {{"Content-Length", "3"}}, BodyClaim::kSome},
        {"a length no integer holds", {{"Content-Length", "99999999999999999999999"}}, BodyClaim::kSome},
        {"second length differs", {{"Content-Length", "0"}, {"Content-Length", "5"}}, BodyClaim::kSome},
        {"negative", {{"Content-Length", "-1"}}, BodyClaim::kMalformed},
        {"empty", {{"Content-Length", ""}}, BodyClaim::kMalformed},
        {"hexadecimal", {{"Content-Length", "0x5"}}, BodyClaim::kMalformed},
        {"chunked", {{"TRANSFER-ENCODING", "chunked"}}, BodyClaim::kMalformed},
        {"identity", {{"Transfer-Encoding", "identity"}, {"Content-Length", "0"}}, BodyClaim::kMalformed},
    }));
    DYNAMIC_SECTION(c.name) { CHECK(body_claim(Request{"GET", "/", c.headers}) == c.claim); }
}

TEST_CASE("a problem is JSON whatever its detail holds", "[voxelserver][http]") {
    const Response r = problem(404, "no \"such\" thing\n\xff\xfe");
    const auto json = nlohmann::json::parse(*r.body);
    CHECK(json["status"] == 404);
    CHECK(json["title"] == "Not Found");
    CHECK(json["type"] == "about:blank");
    CHECK_THAT(json["detail"].get<std::string>(), terravox::test::contains("no \"such\" thing"));
    CHECK(*r.header("content-type") == "application/problem+json");
}

TEST_CASE("headers are found in any case and joined in order", "[voxelserver][http]") {
    const Request r{"GET", "/", {{"If-None-Match", "\"a\""}, {"X", "1"}, {"if-none-match", "\"b\""}}};
    CHECK(r.header("IF-NONE-MATCH") == "\"a\", \"b\"");
    CHECK(r.header("Y").empty());
    CHECK(r.has_header("x"));
}
