// Animations: keys, turntable, day, and what they make of a scene.
#include "raytracer/core/animate/animation.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace terravox::fuzz {

void run(Input input) {
    const auto animation = animate::Animation::parse(as_text(input), "the input");
    expect(animation.frames() <= animate::Animation::kMaxFrames,
           "no animation has more frames than allowed");
    scene::Scene scene;
    animation.apply_base(scene);
    for (const int frame : {0, animation.frames() / 2, animation.frames() - 1})
        (void)animation.at(frame, scene);
}

}  // namespace terravox::fuzz
