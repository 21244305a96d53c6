#include "voxelserver/make/worlds/minecraft/file_state.hpp"

#include <algorithm>
#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/error.hpp"
#include "common/voxel/bytes.hpp"

namespace terravox::minecraft {
namespace {

namespace fs = std::filesystem;

util::Error cannot_look_at(const fs::path& path, const std::error_code& why) {
    return util::Error("look at the Minecraft world's file " + path.string() + ": " +
                       why.message());
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

}  // namespace terravox::minecraft
