#include "voxelserver/make/worlds/open/open_world.hpp"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "common/util/error.hpp"
#include "voxelserver/make/worlds/archive/archive_kind.hpp"
#include "voxelserver/make/worlds/heightmap/heightmap_world.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"
#include "voxelserver/make/worlds/lidar/lidar_kind.hpp"
#include "voxelserver/make/worlds/luanti/luanti_world.hpp"
#include "voxelserver/make/worlds/minecraft/minecraft_world.hpp"
#include "voxelserver/make/worlds/procedural/procedural_world.hpp"
#include "voxelserver/make/worlds/remote/remote_world.hpp"

namespace terravox::worlds {

namespace fs = std::filesystem;

std::span<const WorldKind* const> world_kinds() noexcept {
    // A folder with a store also holds LAZ files, and an address of an archive is an address. The
    // check for Minecraft worlds traverses nested folders; that for Luanti's does not.
    static constexpr std::array<const WorldKind*, 9> kKinds{
        &kRemoteArchiveKind, &kServerKind, &kProceduralKind, &kStoreKind,     &kArchiveKind,
        &kLidarKind,         &kLuantiKind, &kMinecraftKind,  &kHeightmapKind,
    };
    return kKinds;
}

std::string allowed_inputs() {
    std::string out;
    const auto add_all = [&out](bool paths) {
        for (const WorldKind* const kind : world_kinds()) {
            if (kind->is_path == paths && !kind->input.empty())
                out += std::string(kind->input) + ", ";
        }
    };
    add_all(true);
    add_all(false);
    constexpr std::string_view kLast = ", ";
    out.resize(out.size() - kLast.size());
    return out;
}

namespace {

/// Without this check a folder that cannot be read would hold no world.
void check_readable(const std::string& input, const fs::file_status& status) {
    const bool is_folder = fs::is_directory(status);
    if (fs::exists(status) && ::access(input.c_str(), is_folder ? R_OK | X_OK : R_OK) != 0)
        throw util::Error(
            "open the world: the {}{}: {}; allowed: what the user of this program may read",
            std::string(is_folder ? "folder " : "file "), input, std::strerror(errno));
}

[[noreturn]] void refuse(const std::string& input, const fs::file_status& status) {
    std::string what = "open the world: the file " + input + " is of no known kind";
    if (!fs::exists(status))
        what = "open the world: " + input + " does not exist";
    else if (fs::is_directory(status))
        what = "open the world: the folder " + input + " holds no world";
    const std::string remedy = find_remedy(input);
    throw util::UsageError("{}{}{} allowed: {}", what, remedy.empty() ? "" : ": " + remedy,
                           remedy.ends_with('?') ? "" : ";", allowed_inputs());
}

}  // namespace

const WorldKind& find_kind(const std::string& input) {
    const bool is_address = is_http_address(input);
    if (const std::string remedy = is_address ? find_address_remedy(input) : ""; !remedy.empty())
        throw util::UsageError("open the world: {}: {}", input, remedy);
    std::error_code failed;
    const fs::file_status status = fs::status(input, failed);
    if (failed && status.type() != fs::file_type::not_found && !is_address)
        throw util::Error("open the world: {}: {}", input, failed.message());
    check_readable(input, status);
    for (const WorldKind* const kind : world_kinds()) {
        const bool may_be = !kind->is_path || fs::exists(status);
        if (may_be && kind->recognises(input))
            return *kind;
    }
    refuse(input, status);
}

}  // namespace terravox::worlds
