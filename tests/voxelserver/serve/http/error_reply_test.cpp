#include "voxelserver/serve/http/service.hpp"

#include <functional>
#include <new>
#include <nlohmann/json.hpp>

#include "common/util/error.hpp"
#include "common/voxel/world.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/data/store/warnings.hpp"
#include "voxelserver/serve/boxes/admission_control.hpp"

using namespace terravox;
using http::Response;

namespace {

Response reply_to(const std::function<void()>& failing) {
    try {
        failing();
    } catch (...) {
        return http::reply_to_current_exception({"GET", "/v2/boxes/0/0/0/0", {}});
    }
    return {};
}

}  // namespace

TEST_CASE("each exception has its reply, and its line in the log", "[voxelserver][http][error]") {
    struct Case {
        const char* name;
        std::function<void()> failing;
        int status;
        const char* detail;
        const char* retry_after;
        const char* log;  ///< "" = no line
    };
    const auto c = GENERATE(values<Case>({
        {"too many at work", [] { throw boxes::OverloadedError("make a box: too many"); }, 503,
         "make a box: too many", "1", ""},
        {"another server is silent",
         [] { throw voxel::UnreachableError("fetch http://10.0.0.7: refused"); }, 502,
         "the server that this world comes from does not answer, or refuses; the log says why", "5",
         "GET /v2/boxes/0/0/0/0: fetch http://10.0.0.7: refused\n"},
        {"no memory", [] { throw std::bad_alloc(); }, 500, "out of memory", "",
         "GET /v2/boxes/0/0/0/0: out of memory\n"},
        {"a damaged file", [] { throw util::Error("read /home/ann/a.laz: cut short"); }, 500,
         "read a.laz: cut short", "", "GET /v2/boxes/0/0/0/0: read /home/ann/a.laz: cut short\n"},
        {"something else", [] { throw 7; }, 500, "unknown error", "",
         "GET /v2/boxes/0/0/0/0: unknown error\n"},
    }));
    DYNAMIC_SECTION(c.name) {
        const test::Warnings log;
        const Response reply = reply_to(c.failing);
        CHECK(reply.status == c.status);
        CHECK(reply.header("Content-Type") == "application/problem+json");
        CHECK(reply.header("Retry-After") == c.retry_after);
        REQUIRE(reply.body);
        CHECK(nlohmann::json::parse(*reply.body)["detail"] == c.detail);
        CHECK(log.text() == c.log);
    }
}
