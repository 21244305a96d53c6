#include "raytracer/render/loaded_world.hpp"

#include "common/thread/parallel.hpp"
#include "common/util/cache_dir.hpp"
#include "raytracer/world/http_origin.hpp"
#include "raytracer/world/open_world.hpp"
#include "raytracer/world/recognise.hpp"

namespace terravox {
namespace {

/// Where workers may have boxes from themselves. A server on this machine is none that they can
/// reach.
BoxSource box_source(const WorldArguments& world, const Scene& base, const std::stop_token& stop) {
    BoxSource out;
    const std::string& input = world.inputs.front();
    switch (recognise(input)) {
        case Origin::kGenerated:
            out.generated = input.find(':') != std::string::npos
                                ? input
                                : "generated:" + std::to_string(base.generated.seed);
            break;
        case Origin::kServer:
        case Origin::kFarArchive: {
            // By where it leads, not by how it is written: workers elsewhere would ask themselves.
            const AddressRanges ranges = ranges_of_host(HttpOrigin::of(input), stop);
            if (!ranges.holds(AddressRange::kLoopback) && !ranges.holds(AddressRange::kNoMachine))
                out.server = input;
            break;
        }
        default: break;
    }
    return out;
}

}  // namespace

LoadedWorld::LoadedWorld(const WorldArguments& from, const Scene& scene,
                         const std::stop_token& stop)
    : inputs(from.inputs),
      orthophotos(from.orthophoto_paths()),
      source(box_source(from, scene, stop)),
      world(open_world(inputs, orthophotos, scene, times, util::cache_dir(from.cache), stop)),
      blocks(*world, static_cast<std::size_t>(scene.processing.memory_mib) << 20,
             world->worth_asking(thread::thread_count(scene.processing.threads.value_or(0)))) {}

}  // namespace terravox
