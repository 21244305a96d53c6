#include "raytracer/apps/preview/notices.hpp"

#include "common/voxel/world.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using preview::FinalRender;
using preview::Notices;

namespace {

FinalRender::Status final_render(FinalRender::State state, const std::string& message = "") {
    FinalRender::Status out;
    out.state = state;
    out.message = message;
    return out;
}

}  // namespace

TEST_CASE("a warning of the log is shown once, and not logged again", "[preview]") {
    const auto world = test::landscape();
    blocks::BlockManager blocks(*world, std::size_t{1} << 20);
    const auto log = std::make_shared<preview::LogTail>();
    Notices notices(log);
    CHECK(notices.take(blocks, {}).empty());
    log->log({"a test", spdlog::level::warn, "the first worker is lost"});
    log->log({"a test", spdlog::level::warn, "the second worker is lost"});
    const auto taken = notices.take(blocks, {});
    REQUIRE(taken.size() == 1);  // of many lines only the last would be readable
    CHECK(taken.front().text == "the second worker is lost");
    CHECK(taken.front().bad);
    CHECK(taken.front().logged);
    CHECK(notices.take(blocks, {}).empty());
    CHECK(Notices(nullptr).take(blocks, {}).empty());
}

TEST_CASE("a world whose data were replaced is reported once", "[preview]") {
    const auto world = test::landscape();
    const voxel::BoxKey key{0, 0, 0, 0};
    world->make_hole(key, [] { throw voxel::ChangedError("the world has changed"); });
    blocks::BlockManager blocks(*world, std::size_t{1} << 20);
    Notices notices(nullptr);
    CHECK(notices.take(blocks, {}).empty());
    (void)blocks.get(key);
    const auto taken = notices.take(blocks, {});
    REQUIRE(taken.size() == 1);
    CHECK_THAT(taken.front().text, test::contains("the world has changed"));
    CHECK(taken.front().bad);
    CHECK_FALSE(taken.front().logged);
    CHECK(notices.take(blocks, {}).empty());
}

TEST_CASE("the end of a final picture is reported once, as a problem where it is one",
          "[preview]") {
    struct Case {
        const char* name;
        FinalRender::State state;
        const char* message;
        bool bad;
    };
    const auto c = GENERATE(values<Case>({
        {"finished", FinalRender::State::kDone, "wrote a.png", false},
        {"failed", FinalRender::State::kFailed, "the disk is full", true},
        {"given up by the user", FinalRender::State::kFailed, FinalRender::kGivenUp, false},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto world = test::landscape();
        blocks::BlockManager blocks(*world, std::size_t{1} << 20);
        Notices notices(nullptr);
        CHECK(notices.take(blocks, final_render(c.state, c.message)).empty());  // was seen before
        CHECK(notices.take(blocks, final_render(FinalRender::State::kRunning)).empty());
        const auto taken = notices.take(blocks, final_render(c.state, c.message));
        REQUIRE(taken.size() == 1);
        CHECK(taken.front().text == "the final picture: " + std::string(c.message));
        CHECK(taken.front().bad == c.bad);
        CHECK_FALSE(taken.front().logged);
        CHECK(notices.take(blocks, final_render(c.state, c.message)).empty());
    }
}
