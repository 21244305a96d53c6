#include "raytracer/world/recognise.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_world.hpp"
#include "raytracer/world/far_archive.hpp"
#include "raytracer/world/minecraft/minecraft_world.hpp"
#include "raytracer/world/relief/relief_world.hpp"

namespace terravox {
namespace {

namespace fs = std::filesystem;

bool begins_with(const fs::path& file, std::string_view magic) {
    std::array<char, 8> head{};
    std::ifstream in(file, std::ios::binary);
    return in.read(head.data(), static_cast<std::streamsize>(magic.size())) &&
           std::equal(magic.begin(), magic.end(), head.begin());
}

bool is_lidar_name(const fs::path& file) {
    std::string ending = file.extension().string();
    std::transform(ending.begin(), ending.end(), ending.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return ending == ".las" || ending == ".laz";
}

template <class Is>
bool any_file(const fs::path& folder, const Is& is) {
    std::error_code failed;
    for (fs::directory_iterator it(folder, failed), end; !failed && it != end; it.increment(failed))
        if (it->is_regular_file(failed) && is(it->path()))
            return true;
    return false;
}

Origin of_folder(const fs::path& folder) {
    if (fs::exists(folder / "fishnet.gpkg"))
        return Origin::kStore;
    if (any_file(folder, is_lidar_name))
        return Origin::kLidar;
    if (minecraft::looks_like_minecraft(folder))
        return Origin::kMinecraft;
    if (any_file(folder, [](const fs::path& file) { return relief::is_height_raster(file); }))
        return Origin::kRelief;
    throw UsageError("open the world: nothing in the folder " + folder.string() +
                     " is known; allowed: " + std::string(kOrigins));
}

Origin of_file(const fs::path& file) {
    if (voxel::is_archive(file))
        return Origin::kArchive;
    if (begins_with(file, "LASF") || is_lidar_name(file))
        return Origin::kLidar;
    if (minecraft::looks_like_minecraft(file))
        return Origin::kMinecraft;
    if (relief::is_height_raster(file))
        return Origin::kRelief;
    throw UsageError("open the world: the file " + file.string() +
                     " is nothing that is known; allowed: " + std::string(kOrigins));
}

}  // namespace

Origin recognise(const std::string& input) {
    if (input.starts_with("http://") || input.starts_with("https://"))
        return names_archive(input) ? Origin::kFarArchive : Origin::kServer;
    std::error_code failed;
    const fs::file_status status = fs::status(input, failed);
    if (status.type() == fs::file_type::not_found &&
        (input == "generated" || input.starts_with("generated:")))
        return Origin::kGenerated;
    if (!fs::exists(status))
        throw UsageError("open the world: " + input +
                         " does not exist; allowed: " + std::string(kOrigins));
    return fs::is_directory(status) ? of_folder(input) : of_file(input);
}

std::string_view name_of(Origin origin) noexcept {
    switch (origin) {
        case Origin::kServer: return "the address of a voxel server";
        case Origin::kFarArchive: return "the address of a box archive";
        case Origin::kArchive: return "a box archive";
        case Origin::kGenerated: return "a generated world";
        case Origin::kMinecraft: return "a Minecraft world";
        case Origin::kStore: return "a store";
        case Origin::kRelief: return "a raster of heights";
        case Origin::kLidar: break;
    }
    return "LiDAR data";
}

}  // namespace terravox
