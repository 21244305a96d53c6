// Writes the appearance.bin that is compiled into the voxel server:
// default_appearance MATERIALS.toml OUTPUT
#include <cstdio>
#include <exception>

#include "common/util/atomic_file.hpp"
#include "raytracer/apps/publish/appearance_file.hpp"

namespace {

using namespace terravox;

// The air is that of the default scene, at sea level.
void write(const char* materials, const char* output) {
    const material::MaterialFile file = material::read_materials(materials);
    util::write_file_atomically(output,
                                publish::appearance_file(file.appearances, publish::AirOptions{}));
}

}  // namespace

int main(int argc, char** argv) {
    constexpr int kWrongUsage = 2;
    if (argc != 3) {
        std::fputs("usage: default_appearance MATERIALS.toml OUTPUT\n", stderr);
        return kWrongUsage;
    }
    try {
        write(argv[1], argv[2]);
        return 0;
    } catch (const std::exception& e) {
        std::fprintf(stderr, "default_appearance: %s\n", e.what());
        return 1;
    }
}
