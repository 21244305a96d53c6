#include "raytracer/apps/preview/input_queue.hpp"

#include <random>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;

namespace {

using Frame = std::vector<preview::InputEvent>;

preview::InputEvent press(char key) {
    return preview::KeyInput{key, 0, 0, true};
}
preview::InputEvent release(char key) {
    return preview::KeyInput{key, 0, 0, false};
}
preview::InputEvent types(char character) {
    return preview::CharacterInput{static_cast<unsigned>(character)};
}
preview::InputEvent at(double x, double y) {
    return preview::CursorInput{x, y};
}
preview::InputEvent button(int number, bool down) {
    return preview::ButtonInput{number, down};
}
preview::InputEvent wheel(double y) {
    return preview::WheelInput{0, y};
}

std::vector<Frame> list_frames(const Frame& events) {
    preview::InputQueue queue;
    for (const preview::InputEvent& event : events)
        queue.push(event);
    std::vector<Frame> out;
    while (!queue.empty()) {
        out.push_back(queue.next_frame());
        REQUIRE_FALSE(out.back().empty());
    }
    return out;
}

}  // namespace

TEST_CASE("a frame ends where the next event may belong to something else", "[preview][input]") {
    struct Case {
        const char* name;
        std::vector<Frame> frames;
    };
    const preview::InputEvent click = button(0, true);
    const preview::InputEvent let_go = button(0, false);
    const auto c = GENERATE_COPY(values<Case>({
        {"keys behind a click wait for the frame after it",
         {{at(5, 5), click}, {let_go}, {press('a'), types('a')}, {release('a')}}},
        {"a mouse that moves on does not take the click along",
         {{at(5, 5), click}, {at(9, 9)}, {let_go}, {at(1, 1)}}},
        {"a drag is seen before the button is released", {{click}, {at(2, 2)}, {let_go}}},
        {"a key that is pressed and released is seen down", {{press('a')}, {release('a')}}},
        {"a key that is released and pressed is seen up",
         {{press('a')}, {release('a')}, {press('a')}}},
        {"a key behind a release waits: with Ctrl+Tab a window is chosen by it",
         {{press('a')}, {release('a')}, {press('b')}}},
        {"a command is seen with its modifier",
         {{press('^')}, {press('q')}, {release('q'), release('^')}}},
        {"characters come with their key, in order",
         {{press('1'), types('1')},
          {release('1')},
          {press('<')},
          {release('<')},
          {press('2'), types('2')}}},
        {"a key behind a character waits: fields read characters first",
         {{types('x'), types('y')}, {press('<')}, {release('<')}, {press('z'), types('z')}}},
        {"a click behind typing waits until it is typed", {{press('a'), types('a')}, {click}}},
        {"the wheel turns where the mouse is then",
         {{at(1, 1), wheel(1), wheel(1)}, {at(2, 2), wheel(-1)}}},
        {"both buttons",
         {{click}, {button(1, true)}, {at(3, 3)}, {let_go}, {at(4, 4)}, {button(1, false)}}},
    }));
    DYNAMIC_SECTION(c.name) {
        Frame all;
        for (const Frame& frame : c.frames)
            all.insert(all.end(), frame.begin(), frame.end());
        CHECK(list_frames(all) == c.frames);
    }
}

TEST_CASE("of positions in a row only the last counts", "[preview][input]") {
    CHECK(list_frames({at(1, 1), at(2, 2), at(3, 3), button(0, true), at(4, 4), at(5, 5),
                       button(0, false)}) ==
          std::vector<Frame>{{at(3, 3), button(0, true)}, {at(5, 5)}, {button(0, false)}});
}

TEST_CASE("a key's repetition is dropped while others wait", "[preview][input]") {
    const preview::InputEvent repeat = preview::KeyInput{'a', 0, 0, true, true};
    CHECK(list_frames({repeat, repeat, release('a'), repeat}) ==
          std::vector<Frame>{{repeat}, {release('a')}});
    preview::InputQueue queue;
    for (int i = 0; i < 2; ++i) {
        queue.push(repeat);
        CHECK(queue.next_frame() == Frame{repeat});
    }
}

TEST_CASE("no event is lost, and none overtakes another, wherever frames end", "[preview][input]") {
    const auto seed = GENERATE(range(0U, 50U));
    std::minstd_rand random(seed + 1);
    preview::InputQueue queue;
    Frame given;
    Frame taken;
    std::vector<bool> down(4);
    for (int i = 0; i < 300; ++i) {
        const auto key = static_cast<char>(random() % down.size());
        const preview::InputEvent event =
            random() % 3 == 0 ? types(static_cast<char>('a' + i % 26))
                              : preview::InputEvent(preview::KeyInput{
                                    key, i, 0, !down[static_cast<std::size_t>(key)]});
        if (std::holds_alternative<preview::KeyInput>(event))
            down[static_cast<std::size_t>(key)].flip();
        queue.push(event);
        given.push_back(event);
        if (random() % 2 != 0)
            continue;
        const Frame frame = queue.next_frame();
        taken.insert(taken.end(), frame.begin(), frame.end());
    }
    INFO("seed " << seed);
    while (!queue.empty()) {
        const Frame frame = queue.next_frame();
        REQUIRE_FALSE(frame.empty());
        taken.insert(taken.end(), frame.begin(), frame.end());
    }
    CHECK(taken == given);
}
