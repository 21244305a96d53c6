// Material files, which coordinators send to workers.
#include "raytracer/core/material/appearance.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace terravox::fuzz {

void run(Input input) {
    (void)material::parse_materials(as_text(input), "the input");
}

}  // namespace terravox::fuzz
