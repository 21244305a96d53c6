#include "raytracer/apps/preview/editor_state.hpp"

#include "tests/catch.hpp"

using namespace terravox;
using namespace std::chrono_literals;

namespace {

scene::Scene at_hour(double time_h) {
    scene::Scene out;
    out.sun.time_h = time_h;
    return out;
}

}  // namespace

TEST_CASE("a drag is one step of undo, noted when the scene has stayed the same", "[preview]") {
    const preview::HistoryRecorder::Clock::time_point start;
    const scene::Scene first = at_hour(8);
    preview::SceneHistory history(first);
    preview::HistoryRecorder recorder(start);
    auto now = start;
    for (double hour = 9; hour <= 12; ++hour) {
        now += 300ms;
        recorder.update(history, at_hour(hour), false, now);
        CHECK_FALSE(history.can_undo());
    }
    recorder.update(history, at_hour(12), false, now + 400ms);
    CHECK_FALSE(history.can_undo());
    recorder.update(history, at_hour(12), false, now + 401ms);
    REQUIRE(history.can_undo());
    CHECK(history.now() == at_hour(12));
    CHECK(history.undo() == first);
}

TEST_CASE("nothing is noted while a key is held, however long the scene stays", "[preview]") {
    const preview::HistoryRecorder::Clock::time_point start;
    preview::SceneHistory history(at_hour(8));
    preview::HistoryRecorder recorder(start);
    for (auto now = start; now < start + 10s; now += 500ms)
        recorder.update(history, at_hour(9), true, now);
    CHECK_FALSE(history.can_undo());
    // The wait begins when the key is released: that was in the frame at 9.5 s.
    recorder.update(history, at_hour(9), false, start + 9900ms);
    CHECK_FALSE(history.can_undo());
    recorder.update(history, at_hour(9), false, start + 9901ms);
    CHECK(history.can_undo());
}
