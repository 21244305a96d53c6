#include "raytracer/world/block_manager.hpp"
#include "tests/bench/entries/neutral_scene.hpp"

namespace terravox::bench {
namespace {

constexpr std::size_t kBoxMemory_bytes = std::size_t{1} << 30;

struct Walked {
    explicit Walked(const Context& c) : world(NeutralScene(c).make_world()), blocks(*world, kBoxMemory_bytes), reader(blocks, 0) {}
    std::unique_ptr<voxel::World> world;
    BlockManager blocks;
    BlockReader reader;
};

Entry entry() {
    Entry out;
    out.name = "walk/neutral-scene";
    out.measures = "the walker alone on one thread: primary rays, and rays from their hits towards the sun";
    out.work = "256 x 256 columns of bench/voxel_scene.py, seed 7; three cameras, 1280x720, one ray a pixel";
    out.missing = NeutralScene::missing;
    out.prepare = [](const Context& c) -> Body {
        const auto walked = std::make_shared<Walked>(c);
        return [walked](Readings& readings) {
            for (const auto& [name, camera] : neutral_cameras()) {
                const ViewTimes times = walk_view(walked->reader, camera);
                const double pixels = static_cast<double>(NeutralScene::kWidthPx) * NeutralScene::kHeightPx;
                readings.add(std::string(name) + ": primary", "Mray/s", times.primary_rate());
                readings.add(std::string(name) + ": shadow", "Mray/s", times.shadow_rate());
                readings.add(std::string(name) + ": hits", "%", 100 * static_cast<double>(times.hits) / pixels);
                readings.add(std::string(name) + ": steps", "steps/ray", static_cast<double>(times.primary_steps) / pixels);
            }
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench
