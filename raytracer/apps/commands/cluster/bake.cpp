#include "raytracer/apps/commands/cluster/cluster_command.hpp"

#include <cstdio>
#include <optional>

#include "common/util/log.hpp"
#include "raytracer/apps/commands/cluster/forwarded_arguments.hpp"
#include "raytracer/farm/checkpoint/checkpoint.hpp"
#include "voxelserver/make/voxelize/world/lidar_world.hpp"
#include "voxelserver/make/worlds/lidar/lidar_kind.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"

namespace terravox::cluster {
namespace {

std::int32_t middle_box(std::int32_t min, std::int32_t max) noexcept {
    return (min + (max - min) / 2) >> 6;
}  // 64 columns a box; rounds down

}  // namespace

util::ExitCode prepare_squares(const std::string& command, const std::string& part,
                               const std::vector<std::string>& words) {
    const std::optional<farm::Part> chosen = farm::Part::parse(part);
    if (!chosen)
        throw util::UsageError("cluster bake: --part " + part +
                               "; allowed: " + farm::Part::kAllowed);
    const ForwardedArguments passed = ForwardedArguments::read(command, words);
    util::set_up_log(passed.world.log_level);
    worlds::WorldOptions options = passed.world.options(passed.base_scene());
    if (options.cache_dir.empty())
        throw util::UsageError("cluster bake: --cache " + passed.world.cache +
                               "; allowed: a folder, into which squares are prepared");
    util::StageTimes times;
    // They do not affect a prepared square.
    options.orthophotos.clear();
    options.additions.clear();
    const auto opened = worlds::open_world(options, times);
    auto* world = dynamic_cast<voxelize::LidarWorld*>(opened.get());
    if (world == nullptr)
        throw util::UsageError("cluster bake: " + passed.world.inputs.front() +
                               " holds no LiDAR squares; allowed: " +
                               std::string(worlds::kLidarInputs) + ", or the grabber's store");

    int prepared = 0;
    int there = 0;
    const auto squares = world->squares();
    for (std::size_t i = chosen->index - 1; i < squares.size(); i += chosen->count) {
        const auto& square = squares[i];
        if (square.state == voxelize::SquareState::kPrepared) {
            ++there;
            continue;
        }
        // Any query of the ground in a square's middle loads its points.
        (void)world->ground_heights(middle_box(square.bounds.min_x, square.bounds.max_x),
                                    middle_box(square.bounds.min_z, square.bounds.max_z));
        ++prepared;
    }
    int failed = 0;
    const auto after = world->squares();
    for (std::size_t i = chosen->index - 1; i < after.size(); i += chosen->count) {
        if (after[i].state == voxelize::SquareState::kPrepared)
            continue;
        ++failed;
        util::log_error("prepare {}: {}", after[i].file.string(),
                        after[i].error.empty()
                            ? "it was not kept; is the cache folder full, or not writable?"
                            : after[i].error);
    }
    std::fprintf(stderr, "%d squares prepared, %d were there\n", prepared - failed, there);
    return failed > 0 ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

}  // namespace terravox::cluster
