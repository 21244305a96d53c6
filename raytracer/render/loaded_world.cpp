#include "raytracer/render/loaded_world.hpp"

#include "common/thread/parallel.hpp"
#include "common/util/cache_dir.hpp"
#include "raytracer/world/open_world.hpp"
#include "raytracer/world/recognise.hpp"

namespace terravox {
namespace {

/// Where workers may have boxes from themselves. A server on this machine is none that they can reach.
BoxSource box_source(const WorldArguments& world, const Scene& base) {
    BoxSource out;
    const std::string& input = world.inputs.front();
    switch (recognise(input)) {
        case Origin::kGenerated: out.generated = input.find(':') != std::string::npos ? input : "generated:" + std::to_string(base.generated.seed); break;
        case Origin::kServer:
        case Origin::kFarArchive: {
            const std::string host = input.substr(input.find("://") + 3);
            const bool here = host.starts_with("localhost") || host.starts_with("127.") || host.starts_with("[::1]");
            if (!here) out.server = input;
            break;
        }
        default: break;
    }
    return out;
}

}  // namespace

LoadedWorld::LoadedWorld(const WorldArguments& from, const Scene& scene, const std::stop_token& stop)
    : inputs(from.inputs), orthophotos(from.orthophoto_paths()), source(box_source(from, scene)),
      world(open_world(inputs, orthophotos, scene, times, util::cache_dir(from.cache), stop)),
      blocks(*world, static_cast<std::size_t>(scene.processing.memory_mib) << 20, world->worth_asking(thread::thread_count(scene.processing.threads.value_or(0)))) {}

}  // namespace terravox
