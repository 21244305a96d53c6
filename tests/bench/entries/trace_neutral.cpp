#include <algorithm>
#include <cmath>

#include "common/util/error.hpp"
#include "tests/bench/entries/embree_scene.hpp"
#include "tests/bench/entries/neutral_tracer.hpp"

namespace terravox::bench::trace_neutral_entry {
namespace {

constexpr int kRounds =
    3;  // the fastest of them counts: on a shared machine it is nearest to what the tracers can do
// Shares of the rays that may differ: single precision loses some at edges, and starts shadow rays
// a little before their face.
constexpr double kMaxPrimaryDifference = 0.001;
constexpr double kMaxShadowDifference = 0.01;

/// Rates mean nothing when the two did not see the same.
void check_same(const std::string& name, std::size_t ours, std::size_t theirs, double allowed) {
    const double difference = std::abs(static_cast<double>(ours) - static_cast<double>(theirs));
    if (difference > allowed * static_cast<double>(std::max(ours, theirs)))
        throw util::Error("compare with Embree: " + name + ": " + std::to_string(ours) +
                          " of our rays hit, " + std::to_string(theirs) + " of Embree's");
}

/// A view by our tracer on one thread and on all, and by the peer where there is one.
struct Compared {
    ViewTimes one;
    ViewTimes all;
    ViewTimes peer;
};

Compared trace_in_turns(const NeutralView& view, NeutralTracer& ours, EmbreeScene* embree,
                        int threads) {
    Compared best;
    for (int round = 0; round < kRounds; ++round) {
        const auto trace = [&](TileTracer& tracer, int on, ViewTimes& into) {
            const ViewTimes times = time_view(tracer, view, on);
            if (round == 0)
                into = times;
            else
                into.keep_best(times);
        };
        trace(ours, 1, best.one);
        if (embree != nullptr)
            trace(*embree, 1, best.peer);
        if (threads > 1)
            trace(ours, threads, best.all);
    }
    return best;
}

void add_view(const std::string& name, const Compared& best, bool with_peer, int threads,
              Readings& readings) {
    readings.add(name + ": primary", "Mray/s", best.one.primary_rate());
    if (with_peer) {
        check_same(name, best.one.hits, best.peer.hits, kMaxPrimaryDifference);
        readings.add(name + ": primary, Embree's packets of 16", "Mray/s",
                     best.peer.primary_rate());
        readings.add(name + ": primary / Embree's packets", "x",
                     best.one.primary_rate() / best.peer.primary_rate(), at_least(1));
    }
    readings.add(name + ": occlusion", "Mray/s", best.one.shadow_rate());
    if (with_peer) {
        check_same(name + ", shadow", best.one.shadowed, best.peer.shadowed, kMaxShadowDifference);
        readings.add(name + ": occlusion, Embree's single rays", "Mray/s", best.peer.shadow_rate());
        readings.add(name + ": occlusion / Embree's single rays", "x",
                     best.one.shadow_rate() / best.peer.shadow_rate(), at_least(2));
    }
    if (threads == 1)
        return;
    const std::string cores = name + ": " + std::to_string(threads) + " cores / 1 core";
    readings.add(cores, "x", best.one.wall_s() / best.all.wall_s(), at_least(0.95 * threads));
    // The rate if all cores were ours and busy to the end: it shows what the threads cost each
    // other, on a busy machine, too.
    readings.add(cores + ", by processor time", "x", threads * best.one.cpu_s() / best.all.cpu_s());
}

/// @param build_s from voxels to a tracer that has all boxes
void add_building(const NeutralWorld& world, double build_s, const EmbreeScene* embree,
                  Readings& readings) {
    const auto mib = [](std::size_t bytes) { return static_cast<double>(bytes) / (1 << 20); };
    readings.add("boxes", "MiB", mib(world.memory_bytes()));
    readings.add("boxes from voxels, Nt", "s", build_s);
    if (embree == nullptr)
        return;
    const EmbreeScene::Building& building = embree->building();
    readings.add("Embree: quads", "million", static_cast<double>(building.quads) / 1e6);
    readings.add("Embree: mesh", "MiB", mib(building.mesh_bytes));
    readings.add("Embree: BVH", "MiB", mib(building.bvh_bytes));
    readings.add("Embree: mesh from voxels, Nt", "s", building.mesh_s);
    readings.add("Embree: BVH from mesh, Nt", "s", building.bvh_s);
    readings.add("memory: boxes / Embree's mesh and BVH", "x",
                 static_cast<double>(world.memory_bytes()) / static_cast<double>(building.bytes()),
                 at_most(1.0 / 3));
    readings.add("building: boxes / Embree's mesh and BVH", "x", build_s / building.seconds(),
                 at_most(0.2));
}

void compare(const NeutralScene& scene, int threads, Readings& readings) {
    std::unique_ptr<NeutralWorld> world;
    std::unique_ptr<NeutralTracer> ours;
    const double build_s = measure_seconds([&] {
        world = std::make_unique<NeutralWorld>(scene, threads);
        ours = std::make_unique<NeutralTracer>(*world, threads);
    });
    const auto embree = make_embree_scene(scene, threads);
    add_building(*world, build_s, embree.get(), readings);
    for (const NeutralView& view : neutral_views())
        add_view(view.name, trace_in_turns(view, *ours, embree.get(), threads), embree != nullptr,
                 threads, readings);
}

Entry entry() {
    Entry out;
    out.name = "trace/neutral";
    out.measures =
        "the bare tracer and Embree 4 or 3 (where it was built in) in turns: rays through pixels, "
        "rays from their hits towards the sun; building, memory";
    out.work =
        "1024 x 256 x 1024 voxels of bench/voxel_scene.py, seed 7; three cameras, 1280x720, one "
        "ray a pixel; rates of one thread; the fastest of three";
    out.floor = "Embree on the visible faces of the same voxels; hits must agree";
    out.missing = NeutralScene::missing;
    out.prepare = [](const Context& c) -> Body {
        const auto scene = std::make_shared<const NeutralScene>(c);
        return [scene, threads = c.threads](Readings& readings) {
            compare(*scene, threads, readings);
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::trace_neutral_entry
