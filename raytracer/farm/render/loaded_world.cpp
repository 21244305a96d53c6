#include "raytracer/farm/render/loaded_world.hpp"

#include "common/thread/parallel.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"

namespace terravox::render {
namespace {

/// Where workers can get boxes from themselves. They cannot reach a server on this machine's
/// loopback address.
farm::BoxSource box_source(const worlds::WorldOptions& world, const std::stop_token& stop) {
    farm::BoxSource out;
    // Only here are planned objects in the boxes.
    if (!world.additions.empty())
        return out;
    const std::string& input = world.inputs.front();
    switch (worlds::find_kind(input).farm_access) {
        case worlds::FarmAccess::kFromCoordinator: break;
        case worlds::FarmAccess::kBySeed: {
            const bool has_seed = input.find(':') != std::string::npos;
            out.generated = has_seed ? input : input + ":" + std::to_string(world.generated.seed);
            break;
        }
        case worlds::FarmAccess::kByAddress: {
            // By the resolved address, not by its spelling: workers elsewhere would connect to
            // themselves.
            const remote::AddressRanges ranges =
                remote::ranges_of_host(remote::HttpOrigin::of(input), stop);
            if (!ranges.holds(remote::AddressRange::kLoopback) &&
                !ranges.holds(remote::AddressRange::kNoMachine))
                out.server = input;
            break;
        }
    }
    return out;
}

}  // namespace

LoadedWorld::LoadedWorld(const worlds::WorldOptions& from, const scene::Scene& scene,
                         const std::stop_token& stop)
    : inputs(from.inputs),
      orthophotos(from.orthophotos),
      source(box_source(from, stop)),
      world(worlds::open_world(from, times, stop)),
      blocks(
          *world, static_cast<std::size_t>(scene.processing.memory_mib) << 20,
          world->useful_concurrency(thread::thread_count(scene.processing.threads.value_or(0)))) {}

}  // namespace terravox::render
