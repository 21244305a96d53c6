#include "voxelserver/make/worlds/luanti/luanti_kind.hpp"

#include <filesystem>

#include "common/util/config_dir.hpp"
#include "common/util/log.hpp"
#include "common/voxel/bytes.hpp"
#include "common/voxel/file_identity.hpp"
#include "voxelserver/make/worlds/luanti/describe.hpp"
#include "voxelserver/make/worlds/luanti/luanti_world.hpp"
#include "voxelserver/make/worlds/luanti/world_files.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"

namespace terravox::worlds {
namespace {

bool is_luanti(const std::string& input) {
    return luanti::looks_like_luanti(input);
}

std::filesystem::path node_table() {
    return util::config_dir() / "blocks" / "luanti.toml";
}

minecraft::BlockTable load_nodes() {
    return minecraft::BlockTable::load_names(node_table());
}

std::unique_ptr<voxel::World> open_luanti(const OpenRequest& request) {
    luanti::LuantiWorldOptions options;
    options.path = request.input();
    options.memory_bytes = request.options.memory_bytes;
    options.threads = request.options.threads;
    auto world = luanti::open_luanti_world(options, load_nodes());
    const auto& b = world->info().bounds;
    util::log_info("Luanti world '{}', {} x {} x {} nodes", world->info().title,
                   b.max[0] - b.min[0], b.max[1] - b.min[1], b.max[2] - b.min[2]);
    return world;
}

// While a server plays a world, it writes to the log file next to the map first.
voxel::Fingerprint state_of_files(const worlds::WorldOptions& options) {
    const luanti::WorldFiles files = luanti::find_world_files(options.inputs.front());
    std::filesystem::path log = files.map;
    log += "-wal";
    voxel::ByteWriter out;
    out.add(files.title);
    std::error_code failed;
    for (const auto& file : {files.map, log, node_table()})
        if (file != log || std::filesystem::exists(log, failed))
            out.add(voxel::file_identity(file, "Luanti world"));
    return out.fingerprint();
}

Description describe_luanti(const DescribeRequest& request) {
    return luanti::describe(request, load_nodes());
}

}  // namespace

constinit const WorldKind kLuantiKind{
    .noun = "a Luanti world",
    .input = "a Luanti (Minetest) world (folder)",
    .recognises = is_luanti,
    .open = open_luanti,
    .describe = describe_luanti,
    .state = state_of_files,
};

}  // namespace terravox::worlds
