#include "voxelserver/serve/jobs/job_queue.hpp"

#include <limits>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/eventually.hpp"
#include "tests/voxelserver/serve/jobs/script.hpp"

using namespace terravox;
using jobs::JobState;

namespace {

jobs::QueueOptions make_options(const test::Script& script) {
    jobs::QueueOptions out;
    out.program = script.file();
    out.world = "http://127.0.0.1:1";
    out.token = "s3cret";
    return out;
}

jobs::JobRequest request() {
    return {"sky", 100, {"--area=0,0,1,1"}};
}

jobs::JobStatus find_end(jobs::JobQueue& queue, const std::string& id) {
    std::optional<jobs::JobStatus> status;
    REQUIRE(test::eventually([&] {
        status = queue.status(id);
        return !status || status->state == JobState::kDone || status->state == JobState::kFailed;
    }));
    REQUIRE(status);
    return *status;
}

/// Says that it runs, and goes on until it is ended.
constexpr const char* kEndless = "echo ' 40 %  tile 2 of 5' >&2; while :; do sleep 0.05; done";

bool runs(jobs::JobQueue& queue, const std::string& id) {
    const auto status = queue.status(id);
    return status && status->state == JobState::kRunning && status->progress == 0.4;
}

}  // namespace

TEST_CASE("a job runs the analysis of the server's own world, and has its raster",
          "[voxelserver][jobs]") {
    const test::Script script(
        R"(echo "$*, $TERRAVOX_SERVER_TOKEN for $TERRAVOX_SERVER_ORIGIN" > result.tif)");
    jobs::JobQueue queue(make_options(script));
    const auto id = queue.submit(request());
    REQUIRE(id);
    CHECK(id->size() == 32);
    const jobs::JobStatus end = find_end(queue, *id);
    CHECK(end.state == JobState::kDone);
    CHECK_FALSE(end.has_holes);
    CHECK(end.bytes > 0);
    const auto file = queue.result(*id);
    REQUIRE(file);
    CHECK(test::read_content(*file) ==
          "analyse sky http://127.0.0.1:1 -o result.tif --area=0,0,1,1 --memory-mib=512 "
          "--cache=none, s3cret for http://127.0.0.1:1\n");
    CHECK(queue.remove(*id));
    CHECK_FALSE(std::filesystem::exists(*file));
    CHECK_FALSE(queue.remove(*id));
    CHECK_FALSE(queue.status(*id));
}

TEST_CASE("how a process ends is how its job ends, and one that takes too much is ended",
          "[voxelserver][jobs]") {
    struct Case {
        const char* name;
        const char* script;
        JobState state;
        bool has_holes;
        const char* message;
        void (*limit)(jobs::QueueOptions&) = [](jobs::QueueOptions&) {};
    };
    const auto c = GENERATE(values<Case>({
        {"with holes", "echo x > result.tif; exit 3", JobState::kDone, true, ""},
        {"refused", "echo half > result.tif; echo 'terravox: no such day' >&2; exit 2",
         JobState::kFailed, false, "no such day"},
        {"killed", "kill -9 $$", JobState::kFailed, false, "ended by signal 9"},
        {"silently", "exit 1", JobState::kFailed, false, "status 1"},
        {"too much memory",
         "x=$(head -c 60000000 /dev/zero | tr '\\0' 'x'); while :; do sleep 0.05; done",
         JobState::kFailed, false, "more than 32 MiB",
         [](jobs::QueueOptions& o) { o.limits.memory_mib = 32; }},
        {"too long", kEndless, JobState::kFailed, false, "longer than 0 minutes",
         [](jobs::QueueOptions& o) { o.limits.max_minutes = 0; }},
        {"before the disk is full", kEndless, JobState::kFailed, false, "nearly full",
         [](jobs::QueueOptions& o) { o.spare_bytes = std::numeric_limits<std::uint64_t>::max(); }},
    }));
    DYNAMIC_SECTION(c.name) {
        const test::Script script(c.script);
        jobs::QueueOptions options = make_options(script);
        options.max_kept = 1;
        c.limit(options);
        jobs::JobQueue queue(options);
        std::string id;
        // Failed jobs take no room of results.
        for (int i = 0; i < (c.state == JobState::kFailed ? 2 : 1); ++i) {
            id = queue.submit(request()).value();
            const jobs::JobStatus end = find_end(queue, id);
            CHECK(end.state == c.state);
            CHECK(end.has_holes == c.has_holes);
            CHECK_THAT(end.message, test::contains(c.message));
        }
        CHECK(queue.result(id).has_value() == (c.state == JobState::kDone));
    }
}

TEST_CASE("jobs wait for their turn, and no more than there is room for", "[voxelserver][jobs]") {
    const test::Script script(kEndless);
    jobs::QueueOptions options = make_options(script);
    options.max_waiting = 2;
    jobs::JobQueue queue(options);
    const auto first = queue.submit(request());
    REQUIRE(first);
    REQUIRE(test::eventually([&] { return runs(queue, *first); }));
    CHECK_FALSE(queue.result(*first));
    const auto second = queue.submit(request());
    const auto third = queue.submit(request());
    REQUIRE((second && third));
    CHECK_FALSE(queue.submit(request()));
    CHECK(queue.status(*third)->before == 1);
    CHECK(queue.status(*third)->state == JobState::kWaiting);
    CHECK(queue.counts().waiting == 2);
    CHECK(queue.remove(*second));
    CHECK(queue.status(*third)->before == 0);
    // Deleting the one that runs ends its process, and the next begins.
    CHECK(queue.remove(*first));
    CHECK(test::eventually([&] { return runs(queue, *third); }));
    CHECK(queue.counts().running == 1);
}

TEST_CASE("only the latest results are kept, the last one whatever its size, and none for ever",
          "[voxelserver][jobs]") {
    struct Case {
        const char* name;
        std::size_t max_kept;
        std::uint64_t max_kept_bytes;
        std::size_t kept;
    };
    const auto c = GENERATE(values<Case>({{"by number", 2, 1'000'000, 2},
                                          {"by bytes", 100, 2500, 2},
                                          {"one too large", 100, 500, 1}}));
    DYNAMIC_SECTION(c.name) {
        const test::Script script("head -c 1000 /dev/zero > result.tif");
        jobs::QueueOptions options = make_options(script);
        options.max_kept = c.max_kept;
        options.max_kept_bytes = c.max_kept_bytes;
        options.kept_at_least = std::chrono::seconds(0);
        jobs::JobQueue queue(options);
        std::vector<std::string> ids;
        for (int i = 0; i < 4; ++i) {
            ids.push_back(queue.submit(request()).value());
            CHECK(find_end(queue, ids.back()).state == JobState::kDone);
            CHECK(queue.result(ids.back()));
        }
        for (std::size_t i = 0; i < ids.size(); ++i)
            CHECK(queue.status(ids[i]).has_value() == (i + c.kept >= ids.size()));
        CHECK(queue.counts().kept == c.kept);
    }
    const test::Script script("echo x > result.tif");
    jobs::QueueOptions options = make_options(script);
    options.kept = std::chrono::seconds(0);
    jobs::JobQueue queue(options);
    const std::string id = queue.submit(request()).value();
    CHECK(test::eventually([&] { return !queue.status(id); }));
}

TEST_CASE("no result is dropped for others before its time: they wait for room",
          "[voxelserver][jobs]") {
    const test::Script script("head -c 10000 /dev/zero > result.tif");
    jobs::QueueOptions options = make_options(script);
    const bool by_bytes = GENERATE(false, true);
    constexpr std::uint64_t kOneResult_bytes = (std::uint64_t{64} << 20) + 20'000;
    options.max_kept = by_bytes ? 100 : 1;
    options.max_kept_bytes = by_bytes ? kOneResult_bytes : std::uint64_t{1} << 30;
    jobs::JobQueue queue(options);
    const auto of_one_client = queue.submit(request());
    REQUIRE(of_one_client);
    CHECK(find_end(queue, *of_one_client).state == JobState::kDone);
    const auto of_another = queue.submit(request());
    REQUIRE(of_another);
    const auto waiting = queue.status(*of_another);
    REQUIRE(waiting);
    CHECK(waiting->state == JobState::kWaiting);
    CHECK(waiting->before == 0);
    CHECK_THAT(waiting->message, test::contains("waits for room"));
    CHECK(queue.result(*of_one_client));
    CHECK(queue.remove(*of_one_client));
    CHECK(find_end(queue, *of_another).message.empty());
    CHECK(queue.result(*of_another));
}

TEST_CASE("a queue that stops ends its processes and removes its files", "[voxelserver][jobs]") {
    const test::Script script(std::string("pwd > \"$TERRAVOX_NOTE\"; ") + kEndless);
    ::setenv("TERRAVOX_NOTE", script.note().c_str(), 1);
    std::string folder;
    {
        jobs::JobQueue queue(make_options(script));
        const auto id = queue.submit(request());
        REQUIRE(id);
        REQUIRE(test::eventually([&] { return runs(queue, *id); }));
        folder = script.noted();
        folder.resize(folder.find('\n'));
        CHECK(std::filesystem::is_directory(folder));
        queue.stop();
        CHECK_FALSE(queue.submit(request()));
    }
    ::unsetenv("TERRAVOX_NOTE");
    CHECK_FALSE(std::filesystem::exists(folder));
    CHECK_FALSE(std::filesystem::exists(std::filesystem::path(folder).parent_path()));
}

TEST_CASE("without the program there are no jobs", "[voxelserver][jobs]") {
    jobs::QueueOptions options;
    options.program = "/none/terravox-raytracer";
    CHECK_THROWS_AS(jobs::JobQueue(options), util::Error);
}
