// What a voxel server, an archive or a coordinator says of its world.
#include "common/voxel/world.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace terravox::fuzz {

void run(Input input) {
    const auto info = voxel::world_from_json(as_text(input), "the input");
    const auto again = voxel::world_from_json(voxel::world_to_json(info), "what was written");
    expect(again.bounds == info.bounds && again.levels == info.levels,
           "a world comes back as it was written");
}

}  // namespace terravox::fuzz
