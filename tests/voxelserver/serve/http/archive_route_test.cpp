#include "voxelserver/serve/http/route_answers.hpp"

#include <unistd.h>

#include <fstream>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/serve/http/fake_world.hpp"
#include "voxelserver/serve/http/router.hpp"

using namespace terravox;
using http::Header;
using http::Request;
using http::Response;

namespace fs = std::filesystem;

namespace {

constexpr const char* kPath = "/v2/archive.tvx";
const Header kHost{"Host", "localhost:8888"};
const Header kPage{"Origin", "https://a.example"};

/// A file of ten bytes stands for an archive: the route does not look into it.
struct ArchiveFixture {
    explicit ArchiveFixture(std::vector<std::string> origins = {})
        : router(service(), "", http::HostNames(), http::SharedOrigins(std::move(origins))) {
        write("0123456789");
    }
    [[nodiscard]] http::Service service() {
        http::Service out{world, times, boxes};
        out.archive = file;
        return out;
    }
    /// Each file is a second younger than the one before, whatever the clock of the system.
    void write(const std::string& text) {
        const fs::path other = folder.path() / "other";
        std::ofstream(other) << text;
        fs::last_write_time(other, time += std::chrono::seconds(1));
        fs::rename(other, file);
    }
    Response get(std::vector<Header> headers = {}) {
        return router.handle(Request{"GET", kPath, std::move(headers)});
    }

    const test::TemporaryFolder folder;
    const fs::path file = folder.path() / "place.tvx";
    fs::file_time_type time = fs::file_time_type::clock::now();
    test::FakeWorld world;
    util::StageTimes times;
    boxes::BoxCache boxes{world, times, {.ahead = false}};
    http::Router router;
};

std::string to_text(const Response& r) {
    REQUIRE(r.file);
    std::string out(r.file->bytes, ' ');
    REQUIRE(::pread(*r.file->descriptor, out.data(), out.size(),
                    static_cast<off_t>(r.file->offset)) == static_cast<ssize_t>(out.size()));
    return out;
}

}  // namespace

TEST_CASE("an archive is served whole and in parts", "[voxelserver][http][archive]") {
    ArchiveFixture f;
    const Response whole = f.get();
    CHECK(whole.status == 200);
    CHECK(to_text(whole) == "0123456789");
    CHECK(whole.header("Content-Type") == "application/vnd.terravox.archive");
    CHECK(whole.header("Accept-Ranges") == "bytes");
    CHECK(whole.header("Cache-Control") == "no-cache");
    const std::string etag = whole.header("ETag");
    CHECK(etag.starts_with("\"a-"));
    const Response part = f.get({{"Range", "bytes=2-4"}, {"If-Match", etag}});
    CHECK(part.status == 206);
    CHECK(part.header("Content-Range") == "bytes 2-4/10");
    CHECK(part.header("ETag") == etag);
    CHECK(to_text(part) == "234");
    CHECK(f.router.handle(Request{"HEAD", kPath, {}}).body_bytes() == 10);
    const Response head = f.router.handle(Request{"HEAD", kPath, {{"Range", "bytes=2-4"}}});
    CHECK(head.status == 200);
    CHECK(head.body_bytes() == 10);
    CHECK(f.router.handle(Request{"POST", kPath, {}}).status == 405);
}

TEST_CASE("conditions of a request decide about the reply", "[voxelserver][http][archive]") {
    ArchiveFixture f;
    const std::string etag = f.get().header("ETag");
    const std::string weak = "W/" + etag;
    const std::string several = "\"x\", " + etag;
    struct Case {
        const char* name;
        std::vector<Header> headers;
        int status;
    };
    const std::vector<Case> cases = {
        {"this one", {{"If-Match", etag}}, 200},
        {"one of several", {{"If-Match", several}}, 200},
        {"any", {{"If-Match", "*"}}, 200},
        {"another", {{"If-Match", "\"x\""}}, 412},
        {"a weak tag is not strong", {{"If-Match", weak}}, 412},
        {"no tag", {{"If-Match", "x"}}, 412},
        {"another, and a range", {{"If-Match", "\"x\""}, {"Range", "bytes=0-1"}}, 412},
        {"kept", {{"If-None-Match", etag}}, 304},
        {"kept, weakly", {{"If-None-Match", weak}}, 304},
        {"kept another", {{"If-None-Match", "\"x\""}}, 200},
        {"a range of this one", {{"Range", "bytes=0-1"}, {"If-Range", etag}}, 206},
        {"a range of another", {{"Range", "bytes=0-1"}, {"If-Range", "\"x\""}}, 200},
        {"beyond the end", {{"Range", "bytes=10-"}}, 416},
    };
    for (const Case& c : cases) {
        INFO(c.name);
        const Response r = f.get(c.headers);
        CHECK(r.status == c.status);
        CHECK(r.header("ETag") == etag);
    }
}

TEST_CASE("an archive that replaces another one has a tag of its own",
          "[voxelserver][http][archive]") {
    ArchiveFixture f;
    const Response old = f.get({{"Range", "bytes=0-9"}});
    const std::string etag = old.header("ETag");
    f.write("abcdefghij");
    CHECK(to_text(old) == "0123456789");  // a reply under way is of one archive
    CHECK(f.get({{"Range", "bytes=0-9"}, {"If-Match", etag}}).status == 412);
    const Response now = f.get({{"Range", "bytes=0-3"}});
    CHECK(to_text(now) == "abcd");
    CHECK(now.header("ETag") != etag);
    fs::remove(f.file);
    CHECK(f.get().status == 404);
    fs::create_directory(f.file);
    CHECK(f.get().status == 404);
}

TEST_CASE("copies with the same time have the same tag", "[voxelserver][http][archive]") {
    ArchiveFixture f;
    const std::string etag = f.get().header("ETag");
    const auto time = fs::last_write_time(f.file);
    f.write("0123456789");
    fs::last_write_time(f.file, time);
    CHECK(f.get().header("ETag") == etag);
}

TEST_CASE("a world that is no archive has none", "[voxelserver][http][archive]") {
    test::FakeWorld world;
    util::StageTimes times;
    boxes::BoxCache boxes(world, times, {.ahead = false});
    http::Router router(http::Service{world, times, boxes}, "s3cret");
    CHECK(router.handle(Request{"GET", kPath, {}}).status == 401);
    CHECK(router.handle(Request{"GET", kPath, {{"Authorization", "Bearer s3cret"}}}).status == 404);
}

TEST_CASE("pages of other origins read an archive only where they may",
          "[voxelserver][http][archive]") {
    constexpr const char* kAllow = "Access-Control-Allow-Origin";
    ArchiveFixture closed;
    CHECK(closed.get({kHost, kPage}).status == 403);
    CHECK(closed.get().header(kAllow).empty());

    ArchiveFixture named({"https://a.example", "http://localhost:3000"});
    const Response read = named.get({kHost, kPage, {"Range", "bytes=0-1"}});
    CHECK(read.status == 206);
    CHECK(read.header(kAllow) == "https://a.example");
    CHECK_THAT(read.header("Access-Control-Expose-Headers"),
               test::contains("Content-Range") && test::contains("ETag"));
    CHECK(read.header("Vary") == "Origin");
    CHECK(named.get({kHost}).header("Vary") == "Origin");
    for (const char* other : {"https://b.example", "http://a.example", "https://a.example:444",
                              "https://a.example.b", "null", "*"})
        CHECK(named.get({kHost, {"Origin", other}}).status == 403);
    // A change can be told from a failure by pages, too.
    const Response changed = named.get({kHost, kPage, {"If-Match", "\"x\""}});
    CHECK(changed.status == 412);
    CHECK(changed.header(kAllow) == "https://a.example");
    // All else stays closed.
    for (const char* path : {"/v2/world", "/v2/boxes/0/0/0/0", "/healthz", "/nothing"})
        CHECK(named.router.handle(Request{"GET", path, {kHost, kPage}}).status == 403);

    ArchiveFixture open({"*"});
    const Response any = open.get({kHost, {"Origin", "https://b.example"}});
    CHECK(any.status == 200);
    CHECK(any.header(kAllow) == "*");
    CHECK(any.header("Vary").empty());
    CHECK(open.get({kHost}).header(kAllow) == "*");  // a cache may give it to a page
    // An image of a page has no origin to name.
    CHECK(
        open.get({kHost, {"Sec-Fetch-Site", "cross-site"}, {"Sec-Fetch-Mode", "no-cors"}}).status ==
        403);
}

TEST_CASE("what is no origin is refused", "[voxelserver][http][archive]") {
    for (const char* wrong :
         {"", "a.example", "https://", "https://a.example/", "HTTPS://a.example",
          "https://a.example/page", "ftp://a.example", "https://a b", "null"}) {
        INFO(wrong);
        CHECK_THROWS_AS(http::SharedOrigins({wrong}), util::UsageError);
    }
    CHECK_THROWS_AS(http::SharedOrigins({"*", "https://a.example"}), util::UsageError);
    CHECK_NOTHROW(http::SharedOrigins({"https://a.example:8443", "http://[::1]:80"}));
}
