// What the head of a request makes wrong, without a world that could answer it.
#include "voxelserver/serve/http/request_check.hpp"

#include "tests/catch.hpp"

using namespace terravox;
using namespace std::chrono_literals;
using http::BearerToken;
using http::Header;
using http::Request;
using http::RequestCheck;
using http::Response;
using http::TokenTries;

namespace {

const Header kToken{"Authorization", "Bearer s3cret"};
const Header kStrangeHost{"Host", "attacker.example:8888"};
const Header kOtherOrigin{"Origin", "http://attacker.example"};

RequestCheck check_with(const std::string& token) {
    return {token, http::HostNames("127.0.0.1", {"voxels.example.org"})};
}

std::optional<Response> refusal(RequestCheck& check, const Request& request) {
    return check.refusal(http::match_route(request.path).facts, request);
}

}  // namespace

TEST_CASE("the first reason to refuse a request counts", "[voxelserver][http][check]") {
    // Each case is the one above it without the fault that was found there.
    const Header bad_name{"Bad Name", "1"};
    const Header no_number{"Content-Length", "x"};
    const std::vector<Header> all{bad_name, kStrangeHost, kOtherOrigin, no_number};
    const auto but = [&](std::ptrdiff_t found) {
        return Request{"PUT", "/nothing", std::vector<Header>(all.begin() + found, all.end())};
    };
    struct Case {
        const char* fault;
        Request request;
        int status;
        bool close;
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"a header's name with a blank", but(0), 400, true},
        {"a strange host", but(1), 421, true},
        {"a page of another origin", but(2), 403, true},
        {"a length that is no number", but(3), 400, false},
        {"a body where none belongs", {"PUT", "/nothing", {{"Content-Length", "9"}}}, 413, false},
        {"no token", but(4), 401, false},
        {"no such path", {"PUT", "/nothing", {kToken}}, 404, false},
        {"another method", {"PUT", "/v2/boxes", {kToken}}, 405, false},
        {"no body", {"POST", "/v2/boxes", {kToken}}, 411, true},
    }));
    DYNAMIC_SECTION(c.fault) {
        RequestCheck check = check_with("s3cret");
        const auto refused = refusal(check, c.request);
        REQUIRE(refused);
        CHECK(refused->status == c.status);
        CHECK(refused->close == c.close);
        CHECK(refused->header("Content-Type") == "application/problem+json");
    }
}

TEST_CASE("a request without a fault is not refused", "[voxelserver][http][check]") {
    RequestCheck check = check_with("s3cret");
    CHECK_FALSE(refusal(check, {"POST", "/v2/boxes", {kToken, {"Content-Length", "14"}}}));
    CHECK_FALSE(refusal(check, {"GET", "/v2/world", {kToken, {"Content-Length", "0"}}}));
    CHECK_FALSE(refusal(check, {"HEAD", "/v2/world", {kToken, {"Host", "voxels.example.org"}}}));
    CHECK_FALSE(refusal(check, {"GET",
                                "/",
                                {{"Host", "localhost:8888"},
                                 {"Sec-Fetch-Site", "cross-site"},
                                 {"Sec-Fetch-Mode", "navigate"},
                                 {"Sec-Fetch-Dest", "document"}}}));
}

TEST_CASE("each route accepts its own methods, and names them", "[voxelserver][http][check]") {
    RequestCheck check = check_with("");
    for (const http::RouteFacts& route : http::routes()) {
        if (route.path.front() != '/')
            continue;
        INFO(route.path);
        const std::string allowed(http::to_text(route.methods));
        for (const char* method : {"GET", "HEAD", "POST", "PUT", "DELETE", "OPTIONS", "get", ""}) {
            INFO(method);
            Request request{method, route.path, {}};
            if (http::is_allowed(route.methods, "POST") && request.method == "POST")
                request.headers.push_back({"Content-Length", "2"});
            const auto refused = refusal(check, request);
            const bool accepts = !request.method.empty() && allowed.find(method) != allowed.npos;
            CHECK(refused.has_value() != accepts);
            if (!refused)
                continue;
            CHECK(refused->status == 405);
            CHECK(refused->header("Allow") == allowed);
        }
    }
}

TEST_CASE("a body may be as long as its route says, and no other request may have one",
          "[voxelserver][http][check]") {
    RequestCheck check = check_with("");
    struct Case {
        const char* method;
        const char* path;
        const char* length;
        int status;  ///< 0 = not refused
    };
    const auto c = GENERATE(values<Case>({
        {"POST", "/v2/boxes", "1", 0},
        {"POST", "/v2/boxes", "262144", 0},
        {"POST", "/v2/boxes", "262145", 413},
        {"POST", "/v2/boxes", "99999999999999999999999", 413},
        {"POST", "/v2/boxes", "0", 411},
        {"POST", "/v2/boxes", "-1", 400},
        {"PUT", "/v2/boxes", "1", 413},
        {"POST", "/v2/world", "1", 413},
        {"GET", "/v2/world", "1", 413},
        {"GET", "/v2/world", "0", 0},
    }));
    DYNAMIC_SECTION(c.method << " " << c.path << " " << c.length) {
        const auto refused = refusal(check, {c.method, c.path, {{"Content-Length", c.length}}});
        CHECK((refused ? refused->status : 0) == c.status);
    }
}

TEST_CASE("a request is refused where two machines could read its headers differently",
          "[voxelserver][http][check]") {
    RequestCheck check = check_with("");
    const Header host{"Host", "localhost"};
    const auto c = GENERATE_COPY(values<std::vector<Header>>({
        {host, host},
        {{"", "x"}},
        {{"A:B", "x"}},
        {{"A\tB", "x"}},
        {{"Gr\xc3\xb6\xc3\x9f\x65", "x"}},
        {{"Transfer-Encoding", "chunked"}},
        {{"Content-Length", "1"}, {"Content-Length", "1"}},
    }));
    const auto refused = refusal(check, {"GET", "/v2/world", c});
    REQUIRE(refused);
    CHECK(refused->status == 400);
}

TEST_CASE("only routes that are not open require the token, and none answers to a strange host",
          "[voxelserver][http][check]") {
    RequestCheck closed = check_with("s3cret");
    RequestCheck open = check_with("");
    for (const http::RouteFacts& route : http::routes()) {
        if (route.path.front() != '/')
            continue;
        INFO(route.path);
        const bool only_post = !http::is_allowed(route.methods, "GET");
        Request request{only_post ? "POST" : "GET", route.path, {}};
        if (only_post)
            request.headers.push_back({"Content-Length", "2"});
        CHECK_FALSE(refusal(open, request));
        CHECK_FALSE(open.has_token(request));
        const auto refused = refusal(closed, request);
        CHECK(refused.has_value() != route.open);
        if (refused) {
            CHECK(refused->status == 401);
            CHECK(refused->header("WWW-Authenticate") == "Bearer");
        }
        request.headers.push_back(kToken);
        CHECK_FALSE(refusal(closed, request));
        CHECK(closed.has_token(request));
        request.headers.push_back(kStrangeHost);
        const auto strange = refusal(closed, request);
        REQUIRE(strange);
        CHECK(strange->status == 421);
        CHECK_THAT(*strange->body, test::contains("--public-name"));
    }
}

TEST_CASE("wrong tokens without end are not judged, and those of others are",
          "[voxelserver][http][check]") {
    http::TokenTries::Time now{std::chrono::hours(1000)};
    RequestCheck check("s3cret", http::HostNames(), {}, [&] { return now; });
    const auto ask = [&](std::string_view client, const Header& authorization) {
        Request request{"GET", "/v2/world", {authorization}};
        request.client = client;
        const auto refused = refusal(check, request);
        return refused ? refused->status : 200;
    };
    const Header wrong{"Authorization", "Bearer s3crex"};
    for (int i = 0; i < http::TokenTries::kMax; ++i)
        CHECK(ask("192.0.2.7", wrong) == 401);
    CHECK(ask("192.0.2.7", wrong) == 429);
    CHECK(ask("192.0.2.7", kToken) == 429);
    CHECK(ask("192.0.2.8", kToken) == 200);

    Request request{"GET", "/v2/world", {kToken}};
    request.client = "192.0.2.7";
    CHECK(refusal(check, request)->header("Retry-After") == "1");
    CHECK_FALSE(check.has_token(request));
    request.path = "/healthz";  // tells more to clients with the token, and is open to all
    CHECK_FALSE(refusal(check, request));
    CHECK_FALSE(check.has_token(request));

    now += std::chrono::seconds(1);
    CHECK(ask("192.0.2.7", kToken) == 200);
}

TEST_CASE("wrong tokens count on open paths, too, and requests without one do not",
          "[voxelserver][http][check]") {
    RequestCheck check("s3cret", http::HostNames(), {},
                       [] { return http::TokenTries::Time(std::chrono::hours(1000)); });
    const Request health{"GET", "/healthz", {{"Authorization", "Bearer s3crex"}}};
    for (int i = 0; i < 1000; ++i) {
        CHECK_FALSE(check.has_token(health));
        CHECK(refusal(check, {"GET", "/v2/world", {}})->status == 401);
    }
    CHECK(refusal(check, {"GET", "/v2/world", {kToken}})->status == 429);
}

namespace {

Request with_authorization(std::string_view value) {
    return {"GET", "/v2/world", {{"Authorization", value}}};
}

}  // namespace

TEST_CASE("a token is right as a whole, after its scheme in any case",
          "[voxelserver][http][token]") {
    const BearerToken token("s3cret");
    for (const char* right : {"Bearer s3cret", "bearer s3cret", "BEARER s3cret"})
        CHECK(token.is_in(with_authorization(right)));
    for (const char* wrong : {"Bearer s3cre", "Bearer s3crets", "Bearer s3crets3cret",
                              "Bearer S3cret", "Bearer  s3cret", "Bearer s3cret, Bearer s3cret",
                              "Bearer ", "Bearer", "Basic s3cret", "s3cret", ""}) {
        INFO(wrong);
        CHECK_FALSE(token.is_in(with_authorization(wrong)));
    }
    CHECK_FALSE(token.is_in({"GET", "/v2/world", {}}));
}

TEST_CASE("where none is required, no request has the right token", "[voxelserver][http][token]") {
    const BearerToken none;
    CHECK_FALSE(none.is_required());
    CHECK(BearerToken("s3cret").is_required());
    for (const char* value : {"Bearer s3cret", "Bearer ", ""})
        CHECK_FALSE(none.is_in(with_authorization(value)));
}

namespace {

const TokenTries::Time kStart{1000h};

/// @return how many wrong tokens in a row count, at one time
int count_tries(TokenTries& tries, const std::string& address, TokenTries::Time now) {
    int out = 0;
    while (out < 1000 && tries.count(address, false, now))
        ++out;
    return out;
}

}  // namespace

TEST_CASE("an address may try some wrong tokens at once, then one every second",
          "[voxelserver][http][token]") {
    TokenTries tries;
    CHECK(count_tries(tries, "192.0.2.7", kStart) == TokenTries::kMax);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 999ms) == 0);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 1s) == 1);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 1s) == 0);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 4s) == 3);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 1h) == TokenTries::kMax);
}

TEST_CASE("addresses are limited by themselves, those of an IPv6 network together",
          "[voxelserver][http][token]") {
    struct Case {
        const char* other;
        bool is_the_same;
    };
    const auto c = GENERATE(values<Case>({
        {"192.0.2.8", false},
        {"2001:db8:1::1", false},
        {"2001:db8::2", true},
        {"2001:db8::ffff:0:0:1", true},
        {"2001:db8:0:1::1", false},
    }));
    DYNAMIC_SECTION(c.other) {
        TokenTries tries;
        CHECK(count_tries(tries, "2001:db8::1", kStart) == TokenTries::kMax);
        CHECK(tries.count(c.other, true, kStart) != c.is_the_same);
    }
}

TEST_CASE("an address that has shown the right token is not limited for some time",
          "[voxelserver][http][token]") {
    TokenTries tries;
    CHECK(tries.count("192.0.2.7", true, kStart));
    CHECK(count_tries(tries, "192.0.2.7", kStart + 9min + 50s) == 1000);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 10min) == 10);
    CHECK(count_tries(tries, "192.0.2.7", kStart + 11min) == TokenTries::kMax);
}

TEST_CASE("addresses without end fill no memory, and the latest are remembered",
          "[voxelserver][http][token]") {
    TokenTries tries;
    const auto address = [](std::size_t i) {
        return "10.0." + std::to_string(i / 256) + "." + std::to_string(i % 256);
    };
    for (std::size_t i = 0; i < TokenTries::kMaxKept + 10; ++i)
        CHECK(count_tries(tries, address(i), kStart + std::chrono::milliseconds(i / 10)) ==
              TokenTries::kMax);
    CHECK_FALSE(tries.count(address(TokenTries::kMaxKept + 9), false, kStart + 500ms));
    CHECK(count_tries(tries, address(0), kStart + 500ms) == TokenTries::kMax);
}
