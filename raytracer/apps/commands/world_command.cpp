#include "raytracer/apps/commands/commands.hpp"

#include <CLI/CLI.hpp>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "common/voxel/log_damage.hpp"
#include "common/voxel/world.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"

namespace terravox::commands {
namespace {

struct WorldInfoArguments {
    WorldArguments world;
    bool json = false;
    bool blocks = false;
};

util::ExitCode describe(const WorldInfoArguments& args, const scene::Scene& scene,
                        const worlds::WorldKind& kind) {
    std::string dimension;
    for (const auto& [field, text] : args.world.fields) {
        if (field == "world.dimension")
            dimension = text;
    }
    const worlds::Description description =
        kind.describe({args.world.inputs.front(), dimension, args.blocks, args.json,
                       scene.processing.threads.value_or(0)});
    std::printf("%s\n", description.text.c_str());
    return description.is_damaged ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

/// The texts of a world are a stranger's, and the terminal shows them: so the JSON is ASCII.
std::string to_json(const voxel::WorldInfo& info) {
    const auto facts = nlohmann::json::parse(voxel::world_to_json(info));
    return facts.dump(2, ' ', true, nlohmann::json::error_handler_t::replace);
}

void print(const char* name, const std::string& text) {
    if (!text.empty())
        std::printf("%-14s %s\n", name, util::printable(text).c_str());
}

util::ExitCode make_info(const WorldInfoArguments& args, const scene::Scene& scene,
                         const worlds::WorldKind& kind) {
    util::StageTimes times;
    const auto world = worlds::open_world(args.world.options(scene), times);
    const voxel::WorldInfo& info = world->info();
    if (args.json)
        std::printf("%s\n", to_json(info).c_str());
    else {
        const auto& b = info.bounds;
        print("what", std::string(kind.noun));
        print("title", info.title);
        std::printf("%-14s x %d to %d, y %d to %d, z %d to %d\n", "voxels", b.min[0], b.max[0],
                    b.min[1], b.max[1], b.min[2], b.max[2]);
        std::printf("%-14s %g m\n%-14s %d\n", "voxel", info.voxel_m, "levels", info.levels);
        print("CRS", info.crs);
        if (!info.crs.empty())
            std::printf("%-14s %.2f to %.2f E, %.2f to %.2f N\n", "extent",
                        b.min[0] * info.crs_units_per_voxel, b.max[0] * info.crs_units_per_voxel,
                        -b.max[2] * info.crs_units_per_voxel, -b.min[2] * info.crs_units_per_voxel);
        if (info.centre)
            std::printf("%-14s %.6f, %.6f, map's north at azimuth %.3f degrees\n", "centre",
                        info.centre->lat_deg, info.centre->lon_deg, info.centre->convergence_deg);
        print("licence", info.licence);
        print("attribution", info.attribution);
    }
    const auto damage = world->damage();
    if (!damage.empty())
        voxel::log_damage(damage);
    return damage.empty() ? util::ExitCode::kDone : util::ExitCode::kHoles;
}

util::ExitCode run_world_info(const WorldInfoArguments& args) {
    util::set_up_log(args.world.log_level);
    const scene::Scene scene = args.world.scene();
    const worlds::WorldKind& kind = worlds::find_kind(args.world.inputs.front());
    if (kind.describe != nullptr && args.world.inputs.size() == 1)
        return describe(args, scene, kind);
    if (args.blocks)
        throw util::UsageError("world info --blocks: " + args.world.inputs.front() + " is " +
                               std::string(kind.noun) + "; allowed: a Minecraft world");
    return make_info(args, scene, kind);
}

}  // namespace

std::function<util::ExitCode()> add_world_command(CLI::App& app) {
    auto args = std::make_shared<WorldInfoArguments>();
    args->world.log_level = "warn";
    CLI::App* world = app.add_subcommand("world", "Inspect a world");
    world->require_subcommand(1);
    CLI::App* info =
        world->add_subcommand("info", "What a world is: format, version, extent, counts, damage");
    info->add_option("inputs", args->world.inputs, worlds::allowed_inputs())->required();
    info->add_flag("--json", args->json, "as JSON");
    info->add_flag("--blocks", args->blocks, "of a Minecraft world: count its blocks");
    add_opening_arguments(*info, args->world, {"world", "generated", "processing"});
    return [args] { return run_world_info(*args); };
}

}  // namespace terravox::commands
