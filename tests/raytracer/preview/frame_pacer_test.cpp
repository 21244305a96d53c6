#include "raytracer/preview/frame_pacer.hpp"

#include "tests/catch.hpp"

using namespace terravox;
using namespace std::chrono_literals;
using preview::Activity;
using preview::FramePacer;

namespace {

const FramePacer::Clock::time_point kStart;
constexpr auto kTick = 1us;  // for what is rounded to the clock's resolution

}  // namespace

TEST_CASE("a frame waits for input as long as nothing has to be computed", "[preview]") {
    CHECK(FramePacer::wait_s(Activity::kComputing) == 0);
    CHECK(FramePacer::wait_s(Activity::kAnimated) == Approx(1.0 / 60));
    CHECK(FramePacer::wait_s(Activity::kIdle) == Approx(0.25));
}

TEST_CASE("some frames follow one another after input, whatever woke the window", "[preview]") {
    struct Case {
        const char* name;
        bool had_input;
        std::chrono::milliseconds waited;
        bool settles;
    };
    const auto c = GENERATE(values<Case>({
        {"nothing came in all of the wait", false, 250ms, false},
        {"input came", true, 250ms, true},
        {"an event without input ended the wait", false, 100ms, true},
    }));
    DYNAMIC_SECTION(c.name) {
        FramePacer pacer(kStart);
        CHECK_FALSE(pacer.is_settling());
        auto now = kStart + c.waited;
        CHECK(pacer.begin(kStart, 0.25, c.had_input, now) ==
              Approx(std::chrono::duration<double>(c.waited).count()));
        CHECK(pacer.began() == now);
        CHECK(pacer.is_settling() == c.settles);
        int frames = 0;
        for (; pacer.is_settling(); ++frames) {
            const auto waiting_since = now;
            now += 17ms;
            (void)pacer.begin(waiting_since, 0.017, false, now);
        }
        CHECK(frames == (c.settles ? 3 : 0));
    }
}

TEST_CASE("tracing has what drawing leaves of a frame, and 4 ms of it in any case", "[preview]") {
    FramePacer pacer(kStart);
    auto frame_start = kStart;
    const auto frame = [&](std::chrono::milliseconds drawing) {
        frame_start += 20ms;
        (void)pacer.begin(frame_start, 0, false, frame_start);
        const auto drawn = frame_start + drawing;
        pacer.end(drawn, drawn + 5ms, drawn + 5ms);
    };
    for (int i = 0; i < 100; ++i)
        frame(10ms);
    const auto until = pacer.work_until(frame_start + 1ms);
    CHECK(until > frame_start + 6666us - kTick);
    CHECK(until < frame_start + 6667us + kTick);
    for (int i = 0; i < 100; ++i)
        frame(300ms);
    CHECK(pacer.work_until(frame_start + 300ms) >= frame_start + 304ms - kTick);
    CHECK(pacer.work_until(frame_start + 300ms) <= frame_start + 304ms + kTick);
}

TEST_CASE("the window comes to rest once, until there is activity again", "[preview]") {
    FramePacer pacer(kStart);
    CHECK_FALSE(pacer.comes_to_rest(false));
    CHECK(pacer.comes_to_rest(true));
    CHECK_FALSE(pacer.comes_to_rest(true));
    CHECK_FALSE(pacer.comes_to_rest(false));
    CHECK(pacer.comes_to_rest(true));
}
