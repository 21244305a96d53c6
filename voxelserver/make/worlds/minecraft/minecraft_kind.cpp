#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/folders.hpp"
#include "common/util/log.hpp"
#include "common/voxel/fingerprint.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"
#include "voxelserver/make/worlds/minecraft/minecraft_world.hpp"
#include "voxelserver/make/worlds/minecraft/place_names.hpp"
#include "voxelserver/make/worlds/minecraft/source.hpp"
#include "voxelserver/make/worlds/minecraft/world_info.hpp"

namespace terravox::minecraft {
namespace {

namespace fs = std::filesystem;

util::Error cannot_look_at(const fs::path& path, const std::error_code& why) {
    return util::Error("look at the Minecraft world's file {}: {}", path.string(), why.message());
}

/// Entities and points of interest are stored in regions, too, but hold no blocks.
bool holds_blocks(const fs::path& file) {
    const std::string folder = file.parent_path().filename().string();
    if (folder == "entities" || folder == "poi")
        return false;
    const std::string name = file.filename().string();
    if (name == "level.dat" || name == "terravox.json")
        return true;
    const std::string ending = file.extension().string();
    constexpr std::array<std::string_view, 5> kEndings{".mca", ".mcr", ".mcc", ".nbt", ".chunk"};
    if (std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end())
        return true;
    return name.starts_with("c.") && ending == ".dat";
}

void add_file(voxel::ByteWriter& out, const std::string& name, const fs::path& file) {
    std::error_code failed;
    const std::uintmax_t size = fs::file_size(file, failed);
    if (failed)
        throw cannot_look_at(file, failed);
    const fs::file_time_type time = fs::last_write_time(file, failed);
    if (failed)
        throw cannot_look_at(file, failed);
    out.add(name);
    out.add(static_cast<std::uint64_t>(size));
    out.add(static_cast<std::int64_t>(time.time_since_epoch().count()));
}

template <class Wanted>
void add_folder(voxel::ByteWriter& out, const fs::path& folder, const Wanted& wanted) {
    std::vector<fs::path> files;
    std::error_code failed;
    fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied,
                                        failed);
    for (const fs::recursive_directory_iterator end; !failed && at != end; at.increment(failed)) {
        if (wanted(at->path()) && at->is_regular_file(failed))
            files.push_back(at->path());
    }
    if (failed)
        throw cannot_look_at(folder, failed);
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files)
        add_file(out, file.lexically_relative(folder).string(), file);
}

}  // namespace

voxel::Fingerprint file_state(const fs::path& world, const fs::path& blocks) {
    voxel::ByteWriter out;
    std::error_code failed;
    if (fs::is_directory(world, failed))
        add_folder(out, world, holds_blocks);
    else
        add_file(out, world.filename().string(), world);
    add_folder(out, blocks, [](const fs::path&) { return true; });
    return out.fingerprint();
}

namespace {

bool is_of_minecraft(std::string_view path) {
    const std::string_view name = to_name(path);
    return name == "level.dat" || placed_file(name) || is_bedrock_file(path);
}

// Checks the names in a folder and in those below it; gives up early on a large folder of something
// else.
bool holds_minecraft(const fs::path& folder) {
    constexpr int kDeepest = 4;  // dimensions/minecraft/overworld/region
    constexpr int kMaxNames = 20'000;
    int names = 0;
    std::error_code failed;
    fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied,
                                        failed),
        end;
    for (; !failed && at != end && names < kMaxNames; at.increment(failed), ++names) {
        if (at.depth() >= kDeepest)
            at.disable_recursion_pending();
        if (is_of_minecraft(at->path().generic_string()))
            return true;
    }
    return false;
}

// What it lacks of a world, or that it holds several, is said when it is opened.
bool archive_holds_minecraft(const fs::path& archive) {
    constexpr std::size_t kCacheBytes = std::size_t{1} << 20;
    const auto source = open_zip(archive, kCacheBytes);
    const auto& entries = source->entries();
    return std::any_of(entries.begin(), entries.end(),
                       [](const FileSource::Entry& entry) { return is_of_minecraft(entry.path); });
}

}  // namespace

bool looks_like_minecraft(const fs::path& path) noexcept {
    try {
        std::error_code ignored;
        if (fs::is_directory(path, ignored))
            return holds_minecraft(path);
        if (!fs::is_regular_file(path, ignored))
            return false;
        const std::string name = path.filename().string();
        if (name == "level.dat" || placed_file(name))
            return true;
        const std::string ending = path.extension().string();
        for (const char* own : {".mca", ".mcr", ".nbt", ".chunk"})
            if (ending == own)
                return true;
        return util::read_start(path, 2) == "PK" && archive_holds_minecraft(path);
    } catch (...) {
        return false;
    }
}

}  // namespace terravox::minecraft

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
    const minecraft::WorldFacts facts =
        minecraft::describe(request.input, request.dimension, request.with_blocks, request.threads);
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
