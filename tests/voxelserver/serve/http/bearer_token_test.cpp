#include "voxelserver/serve/http/request_check.hpp"

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
