#include "voxelserver/make/worlds/minecraft/minecraft_world.hpp"
#include "voxelserver/make/worlds/minecraft/place_names.hpp"
#include "voxelserver/make/worlds/minecraft/world_folder.hpp"

namespace terravox::minecraft {
namespace {

namespace fs = std::filesystem;

// Checks the names in a folder and in those below it; gives up early on a large folder of something
// else.
bool holds_minecraft(const fs::path& folder) {
    constexpr int kDeepest = 3;
    constexpr int kMaxNames = 20'000;
    int names = 0;
    std::error_code failed;
    fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied,
                                        failed),
        end;
    for (; !failed && at != end && names < kMaxNames; at.increment(failed), ++names) {
        if (at.depth() >= kDeepest)
            at.disable_recursion_pending();
        const std::string name = at->path().filename().string();
        if (name == "level.dat" || placed_file(name))
            return true;
    }
    return false;
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
        if (ending != ".zip" && ending != ".ZIP")
            return false;
        constexpr std::size_t kCacheBytes = std::size_t{1} << 20;
        return !WorldFolder(path, kCacheBytes).dimensions().empty();
    } catch (...) {
        return false;
    }
}

}  // namespace terravox::minecraft
