// Scenes, which come from files, from coordinators and in pictures.
#include "raytracer/core/scene/scene_io.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace terravox::fuzz {

void run(Input input) {
    scene::Scene scene;
    scene::parse_scene(as_text(input), "the input", scene);
    scene::Scene again;
    scene::parse_scene(scene::to_toml(scene), "what was written", again);
    expect(changed_fields(again, scene).empty(), "a scene comes back as it was written");
}

}  // namespace terravox::fuzz
