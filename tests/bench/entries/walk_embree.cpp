#include <algorithm>
#include <cmath>

#include "common/util/error.hpp"
#include "raytracer/world/block_manager.hpp"
#include "tests/bench/entries/embree_scene.hpp"

namespace terravox::bench {
namespace {

#ifdef TERRAVOX_EMBREE

constexpr std::size_t kBoxMemory_bytes = std::size_t{1} << 30;
// Shares of the rays that may differ: single precision loses some at edges, and starts shadow rays a little before their face.
constexpr double kMostPrimaryDifference = 0.001, kMostShadowDifference = 0.01;

struct Both {
    explicit Both(const Context& c)
        : scene(c), embree(scene), world(scene.make_world()), blocks(*world, kBoxMemory_bytes), reader(blocks, 0) {}
    NeutralScene scene;
    EmbreeScene embree;
    std::unique_ptr<voxel::World> world;
    BlockManager blocks;
    BlockReader reader;
};

/// Rates mean nothing when the two did not see the same.
void check_same(const std::string& name, std::size_t ours, std::size_t theirs, double allowed) {
    const double difference = std::abs(static_cast<double>(ours) - static_cast<double>(theirs));
    if (difference > allowed * static_cast<double>(std::max(ours, theirs)))
        throw Error("compare with Embree: " + name + ": " + std::to_string(ours) + " of our rays hit, " + std::to_string(theirs) +
                    " of Embree's");
}

void compare_view(Both& both, const NamedCamera& view, Readings& readings) {
    const ViewTimes ours = walk_view(both.reader, view.camera), theirs = both.embree.trace_view(view.camera);
    const std::string name = view.name;
    check_same(name, ours.hits, theirs.hits, kMostPrimaryDifference);
    check_same(name + ", shadow", ours.shadowed, theirs.shadowed, kMostShadowDifference);
    readings.add(name + ": primary, Embree", "Mray/s", theirs.primary_rate());
    readings.add(name + ": primary, walker / Embree", "x", ours.primary_rate() / theirs.primary_rate());
    readings.add(name + ": shadow, Embree", "Mray/s", theirs.shadow_rate());
    readings.add(name + ": shadow, walker / Embree", "x", ours.shadow_rate() / theirs.shadow_rate());
}

std::string missing(const Context& c) { return NeutralScene::missing(c); }

Body prepare(const Context& c) {
    const auto both = std::make_shared<Both>(c);
    return [both](Readings& readings) {
        readings.add("mesh", "million quads", static_cast<double>(both->embree.quads()) / 1e6);
        for (const NamedCamera& view : neutral_cameras()) compare_view(*both, view, readings);
    };
}

#else

std::string missing(const Context&) { return "built without Embree 3 (Debian package libembree-dev)"; }
Body prepare(const Context&) { throw Error("compare with Embree: built without it"); }

#endif

Entry entry() {
    Entry out;
    out.name = "walk/neutral-scene/embree";
    out.measures = "Embree 3 on the visible faces of the same voxels, single rays, one thread; above 1 x the walker is faster";
    out.work = "the scene, cameras and rays of walk/neutral-scene, the two tracers in turn; their hits must agree";
    out.floor = "Embree's rays per second";
    out.missing = missing;
    out.prepare = prepare;
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench
