// RemoteWorld::boxes(): many boxes in one request, from servers that do it well, badly, or not at
// all.
#include <algorithm>
#include <atomic>
#include <functional>
#include <future>
#include <map>
#include <nlohmann/json.hpp>

#include "common/util/error.hpp"
#include "common/voxel/box.hpp"
#include "tests/catch.hpp"
#include "tests/eventually.hpp"
#include "tests/voxelserver/make/worlds/remote/batch_bytes.hpp"
#include "tests/voxelserver/make/worlds/remote/served_boxes.hpp"
#include "tests/voxelserver/make/worlds/remote/skipped_waits.hpp"
#include "voxelserver/make/worlds/remote/batch_client.hpp"
#include "voxelserver/make/worlds/remote/remote_world.hpp"

using namespace terravox;
using namespace std::chrono_literals;
using terravox::test::BadServer;
using terravox::test::contains;
using terravox::test::Deed;
using terravox::test::last_record;
using terravox::test::problem;
using terravox::test::record;
using terravox::test::SkippedWaits;
using terravox::test::to_box;
using terravox::test::to_bytes;

namespace {

using Keys = std::vector<voxel::BoxKey>;

const std::string kBatch = "/v2/boxes";
const voxel::BoxKey kAir{0, 4, 1, 4};
const Keys kKeys = {{0, 3, -1, 7}, kAir, {0, 3, 0, 7}, {0, 5, -1, 7}};

std::string find_path(const voxel::BoxKey& key) {
    return kBatch + "/" + voxel::to_string(key);
}

Keys keys_in(const std::string& body) {
    Keys out;
    const auto json = nlohmann::json::parse(body);
    for (const auto& k : json.at("boxes"))
        out.push_back({k.at(0), k.at(1), k.at(2), k.at(3)});
    return out;
}

std::string good_record(const voxel::BoxKey& key) {
    return key == kAir ? record(key, 204, "")
                       : record(key, 200, to_bytes(voxel::compress(*to_box(key))));
}

Deed batch(const std::string& body) {
    return {.type = remote::kBatchMediaType, .body = body};
}

Deed good_batch(const Keys& keys) {
    std::string body;
    for (const voxel::BoxKey& key : keys)
        body += good_record(key);
    return batch(body + last_record(keys.size()));
}

Deed single(const std::string& path) {
    for (const voxel::BoxKey& key : kKeys)
        if (path == find_path(key)) {
            if (key == kAir)
                return {.status = 204};
            return {.type = voxel::kBoxMediaType,
                    .body = to_bytes(voxel::compress(*to_box(key))),
                    .headers = "Content-Encoding: zstd\r\n"};
        }
    return problem(404);
}

/// What is done to a batch of these keys, the n-th time.
using BatchScript = std::function<Deed(const Keys& keys, int n)>;

/// A server, and its world, whose waits between tries are skipped where `clock` is not another one.
struct Served {
    SkippedWaits waits;
    BadServer server;
    util::StageTimes times;
    std::unique_ptr<voxel::World> world;
    explicit Served(
        BatchScript batches, std::chrono::milliseconds timeout = 60s,
        BadServer::Script singles = [](const std::string& path, int) { return single(path); },
        remote::RetryClock* clock = nullptr)
        : server([batches = std::move(batches), singles = std::move(singles)](
                     const std::string& path, int n, const std::string& body) {
              return path == "/v2/world" ? test::good_world()
                     : path == kBatch    ? batches(keys_in(body), n)
                                         : singles(path, n);
          }),
          world(remote::open_remote_world(server.url(), times, timeout, {}, {},
                                          clock != nullptr ? *clock : waits)) {}
    [[nodiscard]] int singles() const {
        int sum = 0;
        for (const voxel::BoxKey& key : kKeys)
            sum += server.requests(find_path(key));
        return sum;
    }
};

struct Outcomes {
    std::map<voxel::BoxKey, voxel::BoxOutcome> of;
    int count = 0;
    [[nodiscard]] std::string failure(const voxel::BoxKey& key) const {
        try {
            if (of.at(key).failure)
                std::rethrow_exception(of.at(key).failure);
        } catch (const util::Error& e) {
            return e.what();
        }
        return "";
    }
    [[nodiscard]] bool good(const voxel::BoxKey& key) const {
        const auto found = of.find(key);
        if (found == of.end() || found->second.failure)
            return false;
        const auto& box = found->second.box;
        return key == kAir
                   ? box == nullptr
                   : box != nullptr && to_bytes(box->blob()) == to_bytes(to_box(key)->blob());
    }
};

Outcomes collect_boxes(voxel::World& world, const Keys& keys = kKeys) {
    Outcomes out;
    world.boxes(keys, [&](const voxel::BoxKey& key, voxel::BoxOutcome outcome) {
        out.of[key] = std::move(outcome);
        ++out.count;
    });
    return out;
}

Deed with_record(const Keys& keys, std::size_t at, const std::string& bytes) {
    std::string body;
    for (std::size_t i = 0; i < keys.size(); ++i)
        body += i == at ? bytes : good_record(keys[i]);
    return batch(body + last_record(keys.size()));
}

}  // namespace

TEST_CASE("many boxes come with one request", "[raytracer][remote][batch]") {
    Served served([](const Keys& keys, int) { return good_batch(keys); });
    CHECK(served.world->preferred_batch() > 1);
    const Outcomes got = collect_boxes(*served.world);
    CHECK(got.count == 4);
    for (const auto& key : kKeys)
        CHECK(got.good(key));
    CHECK(served.server.requests(kBatch) == 1);
    CHECK(served.singles() == 0);
    CHECK(collect_boxes(*served.world, {kKeys[2]}).good(kKeys[2]));
    CHECK(served.server.requests(kBatch) == 1);  // one alone is requested without a batch
    CHECK(collect_boxes(*served.world, {}).count == 0);
}

TEST_CASE("a box of a batch is there before the next one has been sent",
          "[raytracer][remote][batch]") {
    std::atomic<int> come{0};
    std::atomic<bool> waited_in_vain{false};
    Served served([&](const Keys& keys, int) {
        Deed deed = good_batch(keys);
        deed.rest = deed.body.size() - good_record(keys[0]).size() - good_record(keys[1]).size();
        deed.before_rest = [&] { waited_in_vain = !test::eventually([&] { return come == 2; }); };
        return deed;
    });
    served.world->boxes(kKeys, [&](const voxel::BoxKey&, voxel::BoxOutcome) { ++come; });
    CHECK(come == 4);
    CHECK_FALSE(waited_in_vain);
}

TEST_CASE("all boxes come at last, whatever becomes of their batch", "[raytracer][remote][batch]") {
    std::string damaged = good_record(kKeys[2]);
    damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 0x55);
    const auto cut = [](std::size_t lost) {
        return [lost](const Keys& keys, int n) {
            Deed deed = good_batch(keys);
            if (n == 0)
                deed.lost = lost;
            return deed;
        };
    };
    const auto first = [](const Deed& deed) {
        return [deed](const Keys& keys, int n) { return n == 0 ? deed : good_batch(keys); };
    };
    const auto always = [](const Deed& deed) { return [deed](const Keys&, int) { return deed; }; };
    const auto third = [](const std::string& bytes) {
        return [bytes](const Keys& keys, int) {
            return keys.size() == 4 ? with_record(keys, 2, bytes) : good_batch(keys);
        };
    };
    struct Case {
        const char* name;
        BatchScript script;
        int batches;
        int singles;
    };
    const auto c = GENERATE_COPY(values<Case>({
        {"cut in the last record", cut(5), 1, 0},
        {"cut in the last box", cut(100), 1, 1},
        {"cut in another box", cut(good_record(kKeys[3]).size() + 124), 2, 0},
        {"only its beginning", cut(good_batch(kKeys).body.size() - 10), 2, 0},
        {"a damaged box", third(damaged), 1, 1},
        {"a box that cannot be loaded this way", third(record(kKeys[2], 500, "the disk is gone")),
         1, 1},
        {"a box that is busy", third(record(kKeys[2], 503, "busy")), 1, 1},
        {"air with bytes", third(record(kKeys[2], 204, "x")), 1, 1},
        {"a status from elsewhere", third(record(kKeys[2], 418, "")), 1, 1},
        {"a box under another key", third(record(kKeys[2], 200, good_record(kKeys[0]).substr(24))),
         1, 1},
        {"the same box twice", third(good_record(kKeys[0])), 2, 0},
        {"a box that was not requested", third(good_record({0, 9, 9, 9})), 2, 0},
        {"bytes after its end", first(batch(good_batch(kKeys).body + "x")), 1, 0},
        {"no bytes", first(batch("")), 2, 0},
        {"another type", first({.type = "text/html", .body = "<html>"}), 2, 0},
        {"megabytes of another type",
         first({.type = "text/html", .body = std::string(3 << 20, 'x')}), 2, 0},
        {"one box at a time",
         [](const Keys& keys, int) {
             Deed deed = good_batch(keys);
             deed.lost = deed.body.size() - good_record(keys[0]).size();
             return deed;
         },
         3, 1},
        {"always lost",
         [](const Keys& keys, int) {
             Deed deed = good_batch(keys);
             deed.lost = deed.body.size();
             return deed;
         },
         2, 4},
        {"always a page", always({.type = "text/html", .body = "<html>"}), 2, 4},
        {"a busy server", always(problem(503, "Retry-After: 1\r\n")), 1, 4},
    }));
    DYNAMIC_SECTION(c.name) {
        Served served(c.script);
        const Outcomes got = collect_boxes(*served.world);
        CHECK(got.count == 4);
        for (const auto& key : kKeys)
            CHECK(got.good(key));
        CHECK(served.server.requests(kBatch) == c.batches);
        CHECK(served.singles() == c.singles);
    }
}

TEST_CASE("one box that cannot be loaded is an error with its reason; the others come",
          "[raytracer][remote][batch]") {
    Served served(
        [](const Keys& keys, int) { return with_record(keys, 0, record(keys[0], 500, "gone")); },
        60s,
        [](const std::string& path, int) {
            return path == find_path(kKeys[0]) ? problem(500) : single(path);
        });
    const Outcomes got = collect_boxes(*served.world);
    CHECK(got.count == 4);
    CHECK_THAT(got.failure(kKeys[0]),
               contains("HTTP status 500, not today; given up after 3 tries"));
    for (std::size_t i = 1; i < kKeys.size(); ++i)
        CHECK(got.good(kKeys[i]));
    CHECK(served.server.requests(kBatch) == 1);
}

TEST_CASE(
    "a server that knows no batches, or is busy with others, is not sent the next one at once",
    "[raytracer][remote][batch]") {
    const int status = GENERATE(404, 405, 413, 401, 429, 502, 503, 500);
    INFO(status);
    Served served([&](const Keys&, int) { return problem(status); });
    for (int round = 0; round < 3; ++round)
        CHECK(collect_boxes(*served.world).count == 4);
    CHECK(served.server.requests(kBatch) == 1);
    CHECK(served.singles() == 12);
}

TEST_CASE("no server holds a batch for ever, and its boxes come alone",
          "[raytracer][remote][batch]") {
    Deed drip = good_batch(kKeys);
    drip.drip = 1000ms;
    struct Case {
        const char* name;
        Deed bad;
    };
    const auto c =
        GENERATE_COPY(values<Case>({{"silent", {.silent = true}}, {"a byte a second", drip}}));
    DYNAMIC_SECTION(c.name) {
        Served served([&](const Keys&, int) { return c.bad; }, 2s);
        const Outcomes got = collect_boxes(*served.world);
        for (const auto& key : kKeys)
            CHECK(got.good(key));
        CHECK(served.server.requests(kBatch) >= 1);
    }
}

TEST_CASE("stop ends a batch at once, and all its boxes report it", "[raytracer][remote][batch]") {
    Deed drip = good_batch(kKeys);
    Deed cut = good_batch(kKeys);
    drip.drip = 100ms;
    cut.lost = cut.body.size();
    struct Case {
        const char* name;
        Deed bad;
    };
    const auto c = GENERATE_COPY(values<Case>({{"silent", {.silent = true}},
                                               {"dripping", drip},
                                               {"lost", cut},
                                               {"busy", problem(503, "Retry-After: 50\r\n")}}));
    DYNAMIC_SECTION(c.name) {
        Served served([&](const Keys&, int) { return c.bad; }, 1h,
                      [](const std::string&, int) { return Deed{.silent = true}; },
                      &remote::RetryClock::steady());
        auto waiting = std::async(std::launch::async, [&] { return collect_boxes(*served.world); });
        // In the middle: the request is out, and what is to come of it has begun to.
        REQUIRE(test::eventually([&] {
            return c.bad.silent ? served.server.requests(kBatch) > 0
                                : served.server.sent_bytes(kBatch) > 0;
        }));
        served.world->stop();
        REQUIRE(waiting.wait_for(test::kHangs) == std::future_status::ready);
        const Outcomes got = waiting.get();
        CHECK(got.count == 4);
        for (const auto& key : kKeys)
            CHECK_THAT(got.failure(key), contains("stopped"));
        const int requests = served.server.requests(kBatch);
        CHECK_THAT(collect_boxes(*served.world).failure(kKeys[3]), contains("stopped"));
        CHECK(served.server.requests(kBatch) == requests);
    }
}

TEST_CASE("a server that has sent nothing for long gets no batch requests until it sends a reply",
          "[raytracer][remote][batch]") {
    std::atomic<bool> back{false};
    Served served(
        [&](const Keys& keys, int) {
            return back ? good_batch(keys) : Deed{.type = "text/html", .body = "moved"};
        },
        1h,
        [&](const std::string& path, int) {
            return back ? single(path) : Deed{.type = "text/html", .body = "moved"};
        });
    std::vector<std::future<Outcomes>> requests_running;
    for (int i = 0; i < 4; ++i)
        requests_running.push_back(
            std::async(std::launch::async, [&] { return collect_boxes(*served.world); }));
    for (auto& one : requests_running)
        CHECK(one.get().count == 4);
    const int requests = served.server.requests(kBatch);
    CHECK(collect_boxes(*served.world).count == 4);
    CHECK(served.server.requests(kBatch) == requests);
    back = true;
    CHECK(collect_boxes(*served.world).good(kKeys[0]));
    CHECK(served.server.requests(kBatch) == requests);
    CHECK(collect_boxes(*served.world).good(kKeys[0]));
    CHECK(served.server.requests(kBatch) == requests + 1);
}

TEST_CASE("batches of many threads give each its own boxes", "[raytracer][remote][batch]") {
    Served served([](const Keys& keys, int n) {
        Deed deed = good_batch(keys);
        if (n % 3 == 1)
            deed.lost = 200;
        return deed;
    });
    std::vector<std::future<Outcomes>> requests_running;
    for (int i = 0; i < 12; ++i)
        requests_running.push_back(
            std::async(std::launch::async, [&] { return collect_boxes(*served.world); }));
    for (auto& one : requests_running) {
        const Outcomes got = one.get();
        CHECK(got.count == 4);
        for (const auto& key : kKeys)
            CHECK(got.good(key));
    }
}
