#include "voxelserver/serve/http/route_answers.hpp"

#include <unistd.h>

#include <nlohmann/json.hpp>

#include "common/voxel/analysis.hpp"
#include "tests/catch.hpp"
#include "tests/eventually.hpp"
#include "tests/voxelserver/serve/http/fake_world.hpp"
#include "tests/voxelserver/serve/jobs/script.hpp"
#include "voxelserver/serve/http/router.hpp"
#include "voxelserver/serve/jobs/job_queue.hpp"

using namespace terravox;
using http::Header;
using http::Request;
using http::Response;

namespace {

nlohmann::json job_json(const Response& r) {
    return nlohmann::json::parse(r.body ? *r.body : "");
}

std::string sent_text(const Response& r) {
    REQUIRE(r.file);
    std::string out(r.file->bytes, ' ');
    REQUIRE(::pread(*r.file->descriptor, out.data(), out.size(),
                    static_cast<off_t>(r.file->offset)) == static_cast<ssize_t>(out.size()));
    return out;
}

jobs::QueueOptions queue_options(const test::Script& program) {
    jobs::QueueOptions out;
    out.max_waiting = 1;
    out.program = program.file();
    out.world = "http://a";
    return out;
}

http::Service with_jobs(http::Service service, jobs::JobQueue& queue) {
    service.jobs = &queue;
    return service;
}

struct JobsFixture {
    explicit JobsFixture(const char* script) : program(script) {}

    test::Script program;
    test::FakeWorld world;
    util::StageTimes times;
    boxes::BoxCache boxes{world, times, {.ahead = false}};
    jobs::JobQueue queue{queue_options(program)};
    http::Router router{with_jobs({world, times, boxes}, queue)};

    Response send(std::string_view method, const std::string& path,
                  std::vector<Header> headers = {}) {
        return router.handle(Request{method, path, std::move(headers)});
    }
    Response post(const std::string& body) {
        const std::string length = std::to_string(body.size());
        return router.handle(Request{"POST", "/v2/jobs", {{"Content-Length", length}}, {}, body});
    }
    /// @return the path of a job that is done
    std::string done() {
        const Response r = post(kSky);
        REQUIRE(r.status == 201);
        const std::string path = "/v2/jobs/" + job_json(r)["id"].get<std::string>();
        REQUIRE(test::eventually([&] { return job_json(send("GET", path))["state"] == "done"; }));
        return path;
    }
    static constexpr const char* kSky = R"({"kind": "sky", "area": [0, 0, 10, 10]})";
};

constexpr const char* kTenBytes = "printf 0123456789 > result.tif";

}  // namespace

TEST_CASE("a server without jobs says how they are turned on", "[voxelserver][http][jobs]") {
    test::FakeWorld world;
    util::StageTimes times;
    boxes::BoxCache boxes(world, times, {.ahead = false});
    http::Router router(http::Service{world, times, boxes});
    for (const char* path : {"/v2/jobs", "/v2/jobs/a", "/v2/jobs/a/result.tif"}) {
        const Response r = router.handle(Request{"GET", path, {}});
        CHECK(r.status == 404);
        CHECK_THAT(job_json(r)["detail"].get<std::string>(), test::contains("--jobs"));
    }
}

TEST_CASE("a job is made, watched, fetched and deleted", "[voxelserver][http][jobs]") {
    JobsFixture f(kTenBytes);
    const auto limits = job_json(f.send("GET", "/v2/jobs"));
    CHECK(limits["max_cells"] == 4'000'000);
    CHECK(limits["kinds"] == voxel::list_analyses());
    CHECK(limits["analyses"].size() == voxel::list_analyses().size());
    CHECK(limits["analyses"][1] == nlohmann::json::parse(R"({"kind": "sky", "days": false,
        "observers": false, "surface": true, "title": "How much sky is seen"})"));
    const std::string path = f.done();
    const auto job = job_json(f.send("GET", path));
    CHECK(job["kind"] == "sky");
    CHECK(job["progress"] == 1.0);
    CHECK(job["bytes"] == 10);
    CHECK("/" + job["result"].get<std::string>() == path + "/result.tif");
    const Response r = f.send("GET", path + "/result.tif");
    CHECK(r.status == 200);
    CHECK(r.header("Content-Type") == "image/tiff");
    CHECK(sent_text(r) == "0123456789");
    CHECK(f.send("HEAD", path + "/result.tif").body_bytes() == 10);
    CHECK(f.send("GET", path + "/result.tif", {{"If-None-Match", r.header("ETag")}}).status == 304);
    CHECK(f.send("DELETE", path).status == 204);
    CHECK(f.send("DELETE", path).status == 404);
    CHECK(f.send("GET", path).status == 404);
    CHECK(f.send("GET", path + "/result.tif").status == 404);
    CHECK(sent_text(r) == "0123456789");  // a reply under way is not cut short
}

TEST_CASE("a raster is read in parts", "[voxelserver][http][jobs]") {
    JobsFixture f(kTenBytes);
    const std::string path = f.done() + "/result.tif";
    const std::string etag = f.send("HEAD", path).header("ETag");
    struct Case {
        const char* name;
        std::vector<Header> headers;
        int status;
        std::string text;
        std::string range;
    };
    const std::vector<Case> cases = {
        {"the beginning", {{"Range", "bytes=0-3"}}, 206, "0123", "bytes 0-3/10"},
        {"beyond the end", {{"Range", "bytes=8-99"}}, 206, "89", "bytes 8-9/10"},
        {"to the end", {{"Range", "bytes=7-"}}, 206, "789", "bytes 7-9/10"},
        {"of the end", {{"Range", "bytes=-2"}}, 206, "89", "bytes 8-9/10"},
        {"of this state", {{"Range", "bytes=1-1"}, {"If-Range", etag}}, 206, "1", "bytes 1-1/10"},
        {"of another", {{"Range", "bytes=1-1"}, {"If-Range", "\"x\""}}, 200, "0123456789", ""},
        {"several", {{"Range", "bytes=1-1,3-3"}}, 200, "0123456789", ""},
        {"backwards", {{"Range", "bytes=3-1"}}, 200, "0123456789", ""},
        {"of lines", {{"Range", "lines=1-2"}}, 200, "0123456789", ""},
        {"no number", {{"Range", "bytes=a-b"}}, 200, "0123456789", ""},
        {"none", {{"Range", "bytes=-"}}, 200, "0123456789", ""},
        {"too far", {{"Range", "bytes=10-"}}, 416, "", "bytes */10"},
        {"nothing of the end", {{"Range", "bytes=-0"}}, 416, "", "bytes */10"},
        {"as far as numbers go",
         {{"Range", "bytes=0-18446744073709551615"}},
         206,
         "0123456789",
         "bytes 0-9/10"},
    };
    for (const Case& c : cases) {
        INFO(c.name);
        const Response r = f.send("GET", path, c.headers);
        CHECK(r.status == c.status);
        CHECK(r.header("Content-Range") == c.range);
        if (c.status != 416)
            CHECK(sent_text(r) == c.text);
    }
}

TEST_CASE("what is no job is refused", "[voxelserver][http][jobs]") {
    JobsFixture f("while :; do sleep 0.05; done");
    CHECK(f.post("{}").status == 400);
    CHECK(f.post(R"({"kind": "sky", "area": [0, 0, 10, 10], "report": "/tmp/a"})").status == 400);
    for (const char* path : {"/v2/jobs/..", "/v2/jobs/", "/v2/jobs/x/result.tif"})
        CHECK(f.send("GET", path).status == 404);
    const auto first = f.post(JobsFixture::kSky);
    REQUIRE(first.status == 201);
    const std::string path = "/v2/jobs/" + job_json(first)["id"].get<std::string>();
    REQUIRE(test::eventually([&] { return job_json(f.send("GET", path))["state"] == "running"; }));
    CHECK(f.send("GET", path + "/result.tif").status == 404);
    CHECK(f.post(JobsFixture::kSky).status == 201);
    const Response full = f.post(JobsFixture::kSky);
    CHECK(full.status == 503);
    CHECK(full.header("Retry-After") == "30");
}

TEST_CASE("the reason of a failure names no folder", "[voxelserver][http][jobs]") {
    JobsFixture f("echo 'terravox: write /tmp/secret/a.tif: disk full' >&2; exit 1");
    const auto made = f.post(JobsFixture::kSky);
    const std::string path = "/v2/jobs/" + job_json(made)["id"].get<std::string>();
    REQUIRE(test::eventually([&] { return job_json(f.send("GET", path))["state"] == "failed"; }));
    CHECK(job_json(f.send("GET", path))["message"] == "write a.tif: disk full");
}

TEST_CASE("jobs require the token", "[voxelserver][http][jobs]") {
    JobsFixture f(kTenBytes);
    http::Router closed(with_jobs({f.world, f.times, f.boxes}, f.queue), "s3cret");
    const std::string path = f.done();
    CHECK(closed.handle(Request{"GET", "/v2/jobs", {}}).status == 401);
    CHECK(closed.handle(Request{"GET", path, {}}).status == 401);
    CHECK(closed.handle(Request{"DELETE", path, {}}).status == 401);
    CHECK(closed.handle(Request{"GET", path + "/result.tif", {}}).status == 401);
    CHECK(closed.handle(Request{"GET", path, {{"Authorization", "Bearer s3cret"}}}).status == 200);
    // A web page of another origin, with a token or without.
    CHECK(f.send("DELETE", path, {{"Host", "localhost"}, {"Origin", "http://a.example"}}).status ==
          403);
    CHECK(f.send("GET", path).status == 200);
}
