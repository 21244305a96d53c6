#include "raytracer/apps/commands/convert/job_name.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "common/util/config_dir.hpp"
#include "common/util/version.hpp"
#include "common/voxel/world_json.hpp"
#include "raytracer/core/scene/scene_io.hpp"

namespace terravox::commands {
namespace {

namespace fs = std::filesystem;

void add_file(std::string& facts, const fs::path& file) {
    std::error_code failed;
    facts += '\n' + file.string() + ' ' + std::to_string(fs::file_size(file, failed));
    if (const auto time = fs::last_write_time(file, failed); !failed)
        facts += ' ' + std::to_string(time.time_since_epoch().count());
}

void add_files(std::string& facts, const fs::path& path) {
    std::error_code failed;
    std::vector<fs::path> files{path};
    for (fs::recursive_directory_iterator it(path, failed), end; !failed && it != end;
         it.increment(failed))
        files.push_back(it->path());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files)
        add_file(facts, file);
}

}  // namespace

std::string job_name(const WorldArguments& arguments, scene::Scene scene, const exports::Part& part,
                     const voxel::World& world, const std::string& form) {
    scene.processing = {};
    scene.world.memory_mib = scene::Scene::World{}.memory_mib;
    std::string facts = std::string(kVersion) + '\n' + scene::to_toml(scene) +
                        voxel::world_to_json(world.info()) + world.edition() + form;
    for (const auto* list : {&arguments.inputs, &arguments.orthophotos})
        for (const std::string& input : *list)
            add_files(facts, input);
    for (const char* folder : {"blocks", "classes", "palettes", "materials.toml", "voxelize.toml"})
        add_files(facts, util::config_dir() / folder);
    for (const std::string& file : {scene.world.settings, scene.world.classes})
        if (!file.empty())
            add_file(facts, file);
    for (std::size_t a = 0; a < 3; ++a)
        facts +=
            ' ' + std::to_string(part.bounds.min[a]) + ' ' + std::to_string(part.bounds.max[a]);
    char hash[17];
    std::snprintf(hash, sizeof hash, "%016llx",
                  static_cast<unsigned long long>(
                      XXH64(facts.data(), facts.size(), static_cast<std::uint64_t>(part.level))));
    return "terravox " + form + " " + hash;
}

}  // namespace terravox::commands
