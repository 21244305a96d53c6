#include "voxelserver/http/bearer_token.hpp"

#include "tests/catch.hpp"

using namespace terravox;
using http::BearerToken;
using http::Request;

namespace {

Request with_authorization(std::string_view value) {
    return {"GET", "/v2/world", {{"Authorization", value}}};
}

}  // namespace

TEST_CASE("a token is right as a whole, after its scheme in any case",
          "[voxelserver][http][token]") {
    struct Case {
        const char* value;
        bool right;
    };
    const auto c = GENERATE(values<Case>({
        {"Bearer s3cret", true},
        {"bearer s3cret", true},
        {"BEARER s3cret", true},
        {"Bearer s3cre", false},
        {"Bearer s3crets", false},
        {"Bearer s3crets3cret", false},
        {"Bearer S3cret", false},
        {"Bearer  s3cret", false},
        {"Bearer s3cret, Bearer s3cret", false},
        {"Bearer ", false},
        {"Bearer", false},
        {"Basic s3cret", false},
        {"s3cret", false},
        {"", false},
    }));
    DYNAMIC_SECTION("'" << c.value << "'") {
        CHECK(BearerToken("s3cret").is_in(with_authorization(c.value)) == c.right);
    }
}

TEST_CASE("without the header there is no token", "[voxelserver][http][token]") {
    CHECK_FALSE(BearerToken("s3cret").is_in({"GET", "/v2/world", {}}));
}

TEST_CASE("where none is required, no request has the right token", "[voxelserver][http][token]") {
    const BearerToken none;
    CHECK_FALSE(none.is_required());
    CHECK(BearerToken("s3cret").is_required());
    for (const char* value : {"Bearer s3cret", "Bearer ", ""})
        CHECK_FALSE(none.is_in(with_authorization(value)));
}
