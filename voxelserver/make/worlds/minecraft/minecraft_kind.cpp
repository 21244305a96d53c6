#include "voxelserver/make/worlds/minecraft/minecraft_kind.hpp"

#include "common/util/config_dir.hpp"
#include "common/util/log.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"
#include "voxelserver/make/worlds/minecraft/file_state.hpp"
#include "voxelserver/make/worlds/minecraft/info.hpp"
#include "voxelserver/make/worlds/minecraft/minecraft_world.hpp"

namespace terravox::worlds {
namespace {

bool is_minecraft(const std::string& input) {
    return minecraft::looks_like_minecraft(input);
}

voxel::Fingerprint state_of_files(const worlds::WorldOptions& options) {
    return minecraft::file_state(options.inputs.front(), util::config_dir() / "blocks");
}

std::unique_ptr<voxel::World> open_minecraft(const OpenRequest& request) {
    minecraft::MinecraftWorldOptions options;
    options.path = request.input();
    options.dimension = request.options.dimension;
    options.memory_bytes = request.options.memory_bytes;
    options.threads = request.options.threads;
    const auto blocks = minecraft::BlockTable::load(util::config_dir() / "blocks");
    auto world = minecraft::open_minecraft_world(options, blocks);
    const auto& b = world->info().bounds;
    util::log_info("Minecraft world '{}', {} x {} x {} blocks", world->info().title,
                   b.max[0] - b.min[0], b.max[1] - b.min[1], b.max[2] - b.min[2]);
    return world;
}

Description describe_minecraft(const DescribeRequest& request) {
    minecraft::DescribeOptions options;
    options.path = request.input;
    options.dimension = request.dimension;
    options.blocks = request.with_blocks;
    options.threads = request.threads;
    const minecraft::WorldFacts facts = minecraft::describe(options);
    Description out;
    out.is_damaged = !facts.damage.empty();
    for (const auto& dimension : facts.dimensions)
        out.is_damaged = out.is_damaged || !dimension.damage.empty();
    if (request.as_json) {
        out.text = minecraft::to_json(facts);
    } else {
        const auto table = minecraft::BlockTable::load(util::config_dir() / "blocks");
        out.text = minecraft::to_text(facts, &table);
    }
    return out;
}

}  // namespace

constinit const WorldKind kMinecraftKind{
    .noun = "a Minecraft world",
    .input = "a Minecraft world (folder or ZIP)",
    .recognises = is_minecraft,
    .open = open_minecraft,
    .describe = describe_minecraft,
    .state = state_of_files,
    .flags = "--dimension",
};

}  // namespace terravox::worlds
