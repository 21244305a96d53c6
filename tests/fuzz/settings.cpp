// Files of settings that are read by their path: class tables, settings of the voxelizer, palettes.
#include "voxelserver/make/voxelize/points/settings.hpp"

#include "tests/fuzz/fuzz.hpp"
#include "voxelserver/data/imagery/palette_file.hpp"
#include "voxelserver/make/voxelize/points/class_table.hpp"

namespace terravox::fuzz {

void run(Input input) {
    const auto path = as_file(input, "input.toml");
    allow_errors([&] { (void)voxelize::load_class_table(path.string()); });
    allow_errors([&] { (void)voxelize::load_settings(path); });
    allow_errors([&] { (void)imagery::read_palette(path.string()); });
}

}  // namespace terravox::fuzz
