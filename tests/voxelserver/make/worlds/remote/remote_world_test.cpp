#include "voxelserver/make/worlds/remote/remote_world.hpp"

#include <future>

#include "common/util/error.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"
#include "tests/catch.hpp"
#include "tests/eventually.hpp"
#include "tests/voxelserver/make/worlds/remote/served_boxes.hpp"
#include "tests/voxelserver/make/worlds/remote/skipped_waits.hpp"
#include "voxelserver/make/worlds/archive/archive_kind.hpp"

using namespace terravox;
using namespace std::chrono_literals;
using terravox::test::BadServer;
using terravox::test::contains;
using terravox::test::Deed;
using terravox::test::problem;
using terravox::test::SkippedWaits;
using terravox::test::to_box;
using terravox::test::to_bytes;
using terravox::test::world_with;

namespace {

const voxel::BoxKey kKey{0, 3, -1, 7};
const std::string kPath = "/v2/boxes/0/3/-1/7";

Deed good_box(const voxel::BoxKey& key = kKey) {
    return {.type = voxel::kBoxMediaType,
            .body = to_bytes(voxel::compress(*to_box(key))),
            .headers = "Content-Encoding: zstd\r\n"};
}
Deed damaged_box() {
    Deed deed = good_box();
    deed.body[deed.body.size() / 2] = static_cast<char>(deed.body[deed.body.size() / 2] ^ 0x55);
    return deed;
}

/// A world whose boxes are bad at first: `bad` says what is done `times` times before a good box
/// comes. The world's waits between tries are skipped.
struct Mended {
    SkippedWaits waits;
    BadServer server;
    util::StageTimes times;
    std::unique_ptr<voxel::World> world;
    Mended(const Deed& bad, int count, std::chrono::milliseconds timeout = 60s)
        : server(world_with(
              [bad, count](const std::string&, int n) { return n < count ? bad : good_box(); })),
          world(remote::open_remote_world(server.url(), times, timeout, {}, {}, waits)) {}
};

/// A world whose boxes never come, and whose waits between tries are real ones: it is to be
/// stopped in the middle of one.
struct Stuck {
    BadServer server;
    util::StageTimes times;
    std::unique_ptr<voxel::World> world;
    explicit Stuck(const Deed& bad)
        : server(world_with([bad](const std::string&, int) { return bad; })),
          world(remote::open_remote_world(server.url(), times, 1h)) {}
};

/// For other threads, in which nothing may be checked.
bool given_up(voxel::World& world, int bx) {
    try {
        (void)world.box({0, bx, 0, 0});
        return false;
    } catch (const util::Error&) {
        return true;
    }
}

}  // namespace

TEST_CASE("a box that comes at last is the box, whatever came before it", "[raytracer][remote]") {
    Deed late = good_box();
    Deed cut = good_box();
    Deed other_type = good_box();
    Deed other_coding = good_box();
    Deed stripped = good_box();
    late.late = 300ms;
    cut.lost = cut.body.size() / 2;
    other_type.type = "text/html";
    other_coding.headers = "Content-Encoding: br\r\n";
    stripped.headers = "";
    struct Case {
        const char* name;
        Deed bad;
        int times;
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"nothing bad", good_box(), 0},
        {"late", late, 1},
        {"busy with a wait", problem(503, "Retry-After: 7\r\n"), 2},
        {"too many requests", problem(429), 1},
        {"bad gateway", problem(502), 3},
        {"the gateway waited too long", problem(504), 1},
        {"a failure inside", problem(500), 2},
        {"another box", good_box({0, 3, -1, 8}), 3},
        {"the same place at another level", good_box({1, 3, -1, 7}), 1},
        {"a damaged body", damaged_box(), 3},
        {"an empty body", {.type = voxel::kBoxMediaType}, 2},
        {"cut short", cut, 3},
        {"a page instead of a box", other_type, 2},
        {"a coding that was not requested", other_coding, 1},
        {"a packed box that says it is not", stripped, 1},
        {"a wait in the past", problem(503, "Retry-After: Sat, 01 Jan 2000 00:00:00 GMT\r\n"), 2},
        {"a senseless wait", problem(503, "Retry-After: -99999999999999999999\r\n"), 1},
    }));
    DYNAMIC_SECTION(c.name) {
        Mended mended(c.bad, c.times);
        const auto box = mended.world->box(kKey);
        REQUIRE(box);
        CHECK((to_bytes(box->blob()) == to_bytes(to_box(kKey)->blob())));
        // A late box is a good one: it is not requested again.
        CHECK(mended.server.requests(kPath) == (c.bad.late > 0ms ? 1 : c.times + 1));
        CHECK((mended.waits.skipped() > 0ms) == (c.times > 0 && c.bad.late == 0ms));
        if (c.bad.headers == "Retry-After: 7\r\n")
            CHECK(mended.waits.skipped() >= 2 * 7s);
    }
}

TEST_CASE("an answer is taken as it is, at the first try", "[raytracer][remote]") {
    Mended air({.status = 204}, 1);
    CHECK(air.world->box(kKey) == nullptr);
    CHECK(air.server.requests(kPath) == 1);
    const int status = GENERATE(400, 401, 403, 404, 406, 418, 501);
    INFO(status);
    Mended mended(problem(status), 1);
    CHECK_THROWS_WITH(
        mended.world->box(kKey),
        contains("HTTP status " + std::to_string(status) + ", not today") && contains(kPath));
    CHECK(mended.server.requests(kPath) == 1);
}

TEST_CASE("what never mends is an error after a few tries, with its reason",
          "[raytracer][remote]") {
    struct Case {
        const char* name;
        Deed bad;
        int tries;
        const char* said;
    };
    const auto c = GENERATE(values<Case>({
        {"fails", problem(500), 3, "not today"},
        {"another box", good_box({0, 3, -1, 8}), 4, "the server sent box 0/3/-1/8"},
        {"damaged", damaged_box(), 4, kPath.c_str()},
        {"a page", {.type = "text/html", .body = "<html>"}, 4, "text/html"},
    }));
    DYNAMIC_SECTION(c.name) {
        Mended mended(c.bad, 1000);
        CHECK_THROWS_AS(mended.world->box(kKey), util::Error);
        CHECK(mended.server.requests(kPath) == c.tries);
        CHECK_THROWS_WITH(
            mended.world->box(kKey),
            contains(c.said) && contains("given up after " + std::to_string(c.tries) + " tries"));
    }
}

TEST_CASE("no server holds a box longer than its timeout", "[raytracer][remote]") {
    Deed drip = good_box();
    Deed slow_head = problem(503, "Retry-After: 1\r\n");
    drip.drip = 1000ms;
    slow_head.late = 900ms;
    struct Case {
        const char* name;
        Deed bad;
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"silent", {.silent = true}},
        {"a byte a second", drip},
        {"busy for ever", problem(503)},
        {"busy, and slow to say so", slow_head},
    }));
    DYNAMIC_SECTION(c.name) {
        Mended mended(c.bad, 1000, 2s);
        // Without the limit it would go on for longer than this test may take.
        CHECK_THROWS_WITH(mended.world->box(kKey),
                          contains("given up after") && contains("timeout 2 s"));
        CHECK(mended.server.requests(kPath) >= 1);
    }
}

TEST_CASE("stop ends a request and a wait at once, and all later ones", "[raytracer][remote]") {
    struct Case {
        const char* name;
        Deed bad;
    };
    Deed drip = good_box();
    drip.drip = 100ms;
    const auto c = GENERATE_COPY(values<Case>({
        {"silent", {.silent = true}},
        {"waiting for a busy server", problem(503, "Retry-After: 50\r\n")},
        {"dripping", drip},
    }));
    DYNAMIC_SECTION(c.name) {
        Stuck stuck(c.bad);
        auto waiting = std::async(std::launch::async, [&] { return stuck.world->box(kKey); });
        // In the middle: the request is out, and what is to come of it has begun to.
        REQUIRE(test::eventually([&] {
            return c.bad.silent ? stuck.server.requests(kPath) > 0
                                : stuck.server.sent_bytes(kPath) > 0;
        }));
        stuck.world->stop();
        stuck.world->stop();
        REQUIRE(waiting.wait_for(test::kHangs) == std::future_status::ready);
        CHECK_THROWS_WITH(waiting.get(), contains("stopped"));
        CHECK_THROWS_WITH(stuck.world->box({0, 0, 0, 0}), contains("stopped"));
        CHECK_THROWS_WITH(stuck.world->column(0, 0, 0), contains("stopped"));
        CHECK(stuck.server.requests(kPath) == 1);
        CHECK(stuck.server.requests("/v2/boxes/0/0/0/0") == 0);
    }
}

TEST_CASE("opening ends when it is to stop, of a server and of an archive elsewhere",
          "[raytracer][remote]") {
    BadServer server(
        BadServer::Script([](const std::string&, int) { return Deed{.silent = true}; }));
    std::stop_source source;
    util::StageTimes times;
    auto world = std::async(std::launch::async, [&] {
        return remote::open_remote_world(server.url(), times, 1h, source.get_token());
    });
    auto archive = std::async(std::launch::async, [&] {
        return worlds::remote_archive(server.url() + "/a.tvx", 1h, source.get_token());
    });
    REQUIRE(test::eventually(
        [&] { return server.requests("/v2/world") > 0 && server.requests("/a.tvx") > 0; }));
    source.request_stop();
    REQUIRE(world.wait_for(test::kHangs) == std::future_status::ready);
    REQUIRE(archive.wait_for(test::kHangs) == std::future_status::ready);
    CHECK_THROWS_WITH(world.get(), contains("stopped"));
    CHECK_THROWS_WITH(archive.get(), contains("stopped"));
}

TEST_CASE("when nothing comes for many boxes, the rest are given up sooner, until something comes",
          "[raytracer][remote]") {
    std::atomic<bool> back{false};
    SkippedWaits waits;
    util::StageTimes times;
    BadServer server(world_with([&](const std::string&, int) {
        return back ? problem(404) : Deed{.type = "text/html", .body = "moved"};
    }));
    // Waits that 16 threads skip are time for each of them.
    const auto world = remote::open_remote_world(server.url(), times, 1h, {}, {}, waits);
    const auto path = [](int i) { return "/v2/boxes/0/" + std::to_string(i) + "/0/0"; };
    std::vector<std::future<bool>> requests_running;
    for (int i = 0; i < 16; ++i)
        requests_running.push_back(
            std::async(std::launch::async, [&world, i] { return given_up(*world, i); }));
    for (auto& one : requests_running)
        CHECK(one.get());
    CHECK(server.requests(path(0)) == 4);
    CHECK_THROWS_AS(world->box({0, 100, 0, 0}), util::Error);
    CHECK(server.requests(path(100)) == 1);
    back = true;
    CHECK_THROWS_WITH(world->box({0, 101, 0, 0}), contains("404"));
    back = false;
    CHECK_THROWS_AS(world->box({0, 102, 0, 0}), util::Error);
    CHECK(server.requests(path(102)) == 4);
}

TEST_CASE("a column is retried like a box", "[raytracer][remote]") {
    SkippedWaits waits;
    util::StageTimes times;
    BadServer server(world_with([](const std::string&, int n) {
        if (n == 0)
            return problem(503);
        if (n == 1)
            return Deed{.body = R"({"by_begin": 1e99, "by_end": 2})"};
        if (n == 2)
            return Deed{.body = R"({"by_begin": 99999999999, "by_end": 2})"};
        return Deed{.body = R"({"by_begin": -2, "by_end": 3})"};
    }));
    const auto world = remote::open_remote_world(server.url(), times, 60s, {}, {}, waits);
    CHECK(world->column(0, 4, 5) == voxel::ColumnExtent{-2, 3});
}

TEST_CASE("a server that cannot be loaded is an error when it is opened", "[raytracer][remote]") {
    SkippedWaits waits;
    util::StageTimes times;
    SECTION("no server listens") {
        const std::string gone = BadServer([](const std::string&, int) { return Deed{}; }).url();
        CHECK_THROWS_WITH(remote::open_remote_world(gone, times, 2s, {}, {}, waits),
                          contains(gone));
    }
    SECTION("silent") {
        BadServer server(
            BadServer::Script([](const std::string&, int) { return Deed{.silent = true}; }));
        CHECK_THROWS_AS(remote::open_remote_world(server.url(), times, 1s), util::Error);
    }
    SECTION("another thing than a voxel server") {
        BadServer server([](const std::string&, int) { return Deed{.body = "{}"}; });
        CHECK_THROWS_AS(remote::open_remote_world(server.url(), times), util::Error);
        CHECK(server.requests("/v2/world") == 1);
    }
    SECTION("busy at first") {
        BadServer server([](const std::string& path, int n) {
            return n < 2 ? problem(503) : world_with({})(path, n);
        });
        const auto world = remote::open_remote_world(server.url(), times, 60s, {}, {}, waits);
        CHECK(world->info().title == "a bad world");
    }
}

TEST_CASE("a head without an end is cut off", "[raytracer][remote]") {
    Deed endless = good_box();
    for (int i = 0; i < 6000; ++i)
        endless.headers += "X-Header-" + std::to_string(i) + ": " + std::string(50, 'x') + "\r\n";
    Mended mended(endless, 1);
    CHECK(mended.world->box(kKey) != nullptr);
    CHECK(mended.server.requests(kPath) == 2);
}

TEST_CASE("a server with another edition than at first ends what is made of its world",
          "[raytracer][remote]") {
    struct Case {
        const char* name;
        const char* header;  ///< of the world's reply
        std::string edition;
    };
    const auto c = GENERATE(values<Case>({
        {"an edition", "Terravox-Edition: 00112233445566778899aabbccddeeff\r\n",
         "00112233445566778899aabbccddeeff"},
        {"none", "", ""},
        {"something else", "Terravox-Edition: a b c\r\n", ""},
        {"too long", "Terravox-Edition: 00112233445566778899aabbccddeeff00\r\n", ""},
    }));
    DYNAMIC_SECTION(c.name) {
        const BadServer server([&](const std::string& path, int) {
            if (path != "/v2/world")
                return problem(412);
            Deed world = terravox::test::good_world();
            world.headers = c.header;
            return world;
        });
        util::StageTimes times;
        const auto world = remote::open_remote_world(server.url(), times, 60s);
        CHECK(world->edition() == c.edition);
        CHECK_THROWS_AS(world->box(kKey), voxel::ChangedError);
        CHECK_THROWS_AS(world->column(0, 3, 7), voxel::ChangedError);
        CHECK(server.requests(kPath) == 1);  // what has changed stays so
    }
}
