#include "voxelserver/worlds/open/world_kinds.hpp"

#include <array>
#include <filesystem>

#include "common/util/error.hpp"
#include "voxelserver/worlds/archive/archive_kind.hpp"
#include "voxelserver/worlds/heightmap/heightmap_kind.hpp"
#include "voxelserver/worlds/lidar/lidar_kind.hpp"
#include "voxelserver/worlds/luanti/luanti_kind.hpp"
#include "voxelserver/worlds/minecraft/minecraft_kind.hpp"
#include "voxelserver/worlds/procedural/procedural_kind.hpp"
#include "voxelserver/worlds/remote/remote_kind.hpp"

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

const WorldKind& kind_of(const std::string& input) {
    std::error_code failed;
    const fs::file_status status = fs::status(input, failed);
    for (const WorldKind* const kind : world_kinds()) {
        const bool may_be = !kind->is_path || fs::exists(status);
        if (may_be && kind->recognises(input))
            return *kind;
    }
    const std::string allowed = "; allowed: " + allowed_inputs();
    if (!fs::exists(status)) {
        throw util::UsageError("open the world: " + input + " does not exist" + allowed);
    }
    if (fs::is_directory(status)) {
        throw util::UsageError("open the world: the folder " + input + " holds no world" + allowed);
    }
    throw util::UsageError("open the world: the file " + input + " is of no known kind" + allowed);
}

}  // namespace terravox::worlds
