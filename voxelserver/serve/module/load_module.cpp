#include "voxelserver/serve/module/load_module.hpp"

#include <dlfcn.h>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/version.hpp"

namespace terravox::module {
namespace {

template <class Function>
Function* function_of_module(const char* name) {
    void* library = util::open_module(TERRAVOX_WORLDS_MODULE, "worlds module");
    auto* function = reinterpret_cast<Function*>(dlsym(library, name));
    if (function == nullptr)
        throw util::Error("load the worlds module " + worlds_module().string() + ": it has no " +
                          name);
    return function;
}

}  // namespace

std::filesystem::path worlds_module() {
    return util::module_file(TERRAVOX_WORLDS_MODULE);
}

std::unique_ptr<voxelize::LidarWorld> open_lidar_world(const voxelize::LidarWorldOptions& options,
                                                       util::StageTimes& times,
                                                       std::size_t image_bytes) {
    auto* open = function_of_module<OpenLidarWorld>(kOpenLidarWorld);
    return std::unique_ptr<voxelize::LidarWorld>(
        open(kVersion, options, times, static_cast<std::int64_t>(image_bytes)));
}

std::unique_ptr<worlds::ServedWorld> open_served_world(const worlds::ServeRequest& request,
                                                       util::StageTimes& times,
                                                       const std::stop_token& stop,
                                                       std::size_t image_bytes) {
    auto* open = function_of_module<OpenServedWorld>(kOpenServedWorld);
    return std::unique_ptr<worlds::ServedWorld>(
        open(kVersion, request, times, stop, static_cast<std::int64_t>(image_bytes)));
}

void place_extents(const std::string& from, const std::string& to_wkt,
                   std::span<std::optional<std::array<double, 4>>> extents) {
    function_of_module<PlaceExtents>(kPlaceExtents)(kVersion, from, to_wkt, extents);
}

}  // namespace terravox::module
