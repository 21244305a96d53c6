// A world of one's own: a sphere of bricks on a lawn, written as a file for Blender.
//   world_of_your_own sphere.glb
#include <terravox/terravox.hpp>

#include <cstdio>
#include <memory>

namespace {

constexpr std::uint8_t kGrass = 4;
constexpr std::uint8_t kMasonry = 30;

class Sphere final : public terravox::VoxelSource {
public:
    [[nodiscard]] terravox::WorldInfo info() const override {
        terravox::WorldInfo out;
        out.title = "a sphere";
        out.block = {0, {-64, 0, -64}, {64, 64, 64}};
        return out;
    }

    // Boxes are made when they are needed, by several threads.
    bool fill(const std::array<std::int32_t, 3>& corner,
              std::span<terravox::Voxel> voxels) override {
        std::size_t i = 0;
        for (int y = corner[1]; y < corner[1] + kHeight; ++y)
            for (int z = corner[2]; z < corner[2] + kWidth; ++z)
                for (int x = corner[0]; x < corner[0] + kWidth; ++x, ++i)
                    voxels[i].material = material(x, y, z);
        return corner[1] == 0;
    }

private:
    static std::uint8_t material(int x, int y, int z) {
        constexpr int kRadius = 24;
        if (y == 0)
            return kGrass;
        const int up = y - kRadius;
        return y > 0 && x * x + up * up + z * z < kRadius * kRadius ? kMasonry : 0;
    }
};

}  // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: world_of_your_own OUT.glb\n");
        return 2;
    }
    try {
        const auto world = terravox::World::of(std::make_shared<Sphere>());
        terravox::ConvertOptions options;
        options.overwrite = true;
        const auto report = world.convert(argv[1], options);
        std::printf("%llu visible voxels\n", static_cast<unsigned long long>(report.voxels));
        return 0;
    } catch (const terravox::Error& e) {
        std::fprintf(stderr, "%s\n", e.what());
        return 1;
    }
}
