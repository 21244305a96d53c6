#include "voxelserver/make/worlds/open/open_world.hpp"

#include <string>
#include <utility>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_reader.hpp"
#include "voxelserver/make/worlds/archive/archive_kind.hpp"
#include "voxelserver/make/worlds/overlay/overlay_world.hpp"
#include "voxelserver/make/worlds/overlay/plane_world.hpp"
#include "voxelserver/make/worlds/remote/remote_world.hpp"

namespace terravox::worlds {
namespace {

using worlds::WorldKind;

/// @throws UsageError where inputs and options do not apply to the kind of the first input
const WorldKind& checked_kind(const WorldOptions& options) {
    const auto& inputs = options.inputs;
    if (inputs.empty()) {
        throw util::UsageError("open the world: nothing given; allowed: " +
                               worlds::allowed_inputs());
    }
    const std::string& first = inputs.front();
    const WorldKind& kind = worlds::find_kind(first);
    const std::string noun(kind.noun);
    for (const std::string& input : inputs) {
        const WorldKind& other = worlds::find_kind(input);
        if (&other != &kind) {
            throw util::UsageError(
                "open the world: {} is {}, {} is {}; allowed: inputs of one kind", first, noun,
                input, other.noun);
        }
    }
    if (inputs.size() > 1 && !kind.takes_several) {
        throw util::UsageError(
            "open the world: {} inputs, of which {} is {}; allowed: one of these", inputs.size(),
            first, noun);
    }
    if (!options.orthophotos.empty() && !kind.takes_orthophotos) {
        const bool is_server = &kind == &kServerKind;
        throw util::UsageError("open the world {}: --ortho with {}{}", first, noun,
                               is_server
                                   ? "; it belongs to the server's own command line"
                                   : "; allowed: with LiDAR data, stores and rasters of heights");
    }
    return kind;
}

}  // namespace

std::unique_ptr<voxel::World> open_address(const std::string& url, const remote::HttpAccess& access,
                                           util::StageTimes& times,
                                           std::chrono::milliseconds timeout,
                                           const std::stop_token& stop) {
    if (names_archive(url))
        return voxel::open_archive(remote_archive(url, timeout, stop, access));
    return remote::open_remote_world(url, times, timeout, stop, access);
}

std::unique_ptr<voxel::World> with_plane(std::unique_ptr<voxel::World> world,
                                         const std::string& plane) {
    if (plane == "table")
        return overlay::on_plane(std::move(world), overlay::Plane::kTable);
    if (plane == "sea")
        return overlay::on_plane(std::move(world), overlay::Plane::kSea);
    return world;
}

std::unique_ptr<voxel::World> open_world(const WorldOptions& options, util::StageTimes& times,
                                         const std::stop_token& stop) {
    return with_plane(overlay::with_additions(checked_kind(options).open({options, times, stop}),
                                              options.additions, stop),
                      options.plane);
}

}  // namespace terravox::worlds
