#include "voxelserver/serve/server/open_for_serving.hpp"

#include <algorithm>
#include <string>

#include "common/util/error.hpp"
#include "voxelserver/make/voxelize/world/store_options.hpp"
#include "voxelserver/make/worlds/kind/http_address.hpp"
#include "voxelserver/make/worlds/kind/suitable_flags.hpp"
#include "voxelserver/make/worlds/lidar/lidar_inputs.hpp"
#include "voxelserver/serve/module/load_module.hpp"

namespace terravox::serve {
namespace {

bool is_lidar_or_store(const std::string& input) {
    return !worlds::is_http_address(input) && (worlds::is_store(input) || worlds::is_lidar(input));
}

OpenedForServing open_lidar(const Options& options, const Plan& plan, util::StageTimes& times) {
    OpenedForServing out;
    const auto& inputs = options.world.inputs;
    std::filesystem::path store = options.store;
    if (inputs.size() == 1 && worlds::is_store(inputs.front()))
        store = inputs.front();
    const bool is_store = !store.empty();
    worlds::check_flags(is_store ? store.string() : inputs.front(),
                        is_store ? "a store" : "LiDAR data", worlds::kLidarFlags,
                        options.kind_flags);
    voxelize::LidarWorldOptions lidar = worlds::lidar_options(options.world);
    lidar.cache_bytes = plan.square_bytes;
    if (is_store) {
        out.store = store::read_grabber_store(store);
        voxelize::take_from_store(*out.store, lidar);
    } else {
        lidar.files.assign(inputs.begin(), inputs.end());
    }
    if (lidar.classes.empty())
        lidar.classes = worlds::WorldOptions{}.classes;
    auto world = std::make_unique<DeferredWorld>(
        lidar, times, DeferredWorld::Means{plan.facts, plan.image_bytes});
    out.lidar = world.get();
    out.world = std::move(world);
    return out;
}

OpenedForServing open_other(const Options& options, const Plan& plan, util::StageTimes& times,
                            const std::stop_token& stop) {
    const worlds::ServeRequest request{options.world, options.kind_flags, module::worlds_module()};
    OpenedForServing out;
    out.world = module::open_served_world(request, times, stop, plan.image_bytes);
    if (stop.stop_requested())
        throw util::Error("open the world " + options.world.inputs.front() + ": stopped");
    return out;
}

}  // namespace

OpenedForServing open_for_serving(const Options& options, const Plan& plan, util::StageTimes& times,
                                  const std::stop_token& stop) {
    const auto& inputs = options.world.inputs;
    const bool all_lidar = std::all_of(inputs.begin(), inputs.end(), is_lidar_or_store);
    if (!options.store.empty() || all_lidar)
        return open_lidar(options, plan, times);
    return open_other(options, plan, times, stop);
}

}  // namespace terravox::serve
