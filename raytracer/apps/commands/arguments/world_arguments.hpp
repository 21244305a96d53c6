#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/core/scene/scene.hpp"
#include "voxelserver/make/worlds/kind/world_options.hpp"

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace terravox::commands {

/// Reads the numbers of a flag, separated by commas.
/// @param allowed the expected text, for messages
/// @return `count` finite numbers; none where the text is empty
/// @throws UsageError "COMMAND: FLAG TEXT; allowed: ..."
[[nodiscard]] std::vector<double> list_numbers(const std::string& command, const std::string& flag,
                                               const std::string& text, std::size_t count,
                                               const std::string& allowed);

/// The arguments that every front end of the tracer has: the world, and every field of the scene.
struct WorldArguments {
    std::vector<std::string> inputs;
    std::vector<std::string> orthophotos;
    std::vector<std::string> additions;  ///< planned objects
    std::string scene_file;
    std::string log_level = "info";
    std::string cache;                                        ///< as for util::cache_dir
    std::vector<std::pair<std::string, std::string>> fields;  ///< path and text, in the order given

    [[nodiscard]] std::vector<std::filesystem::path> orthophoto_paths() const {
        return {orthophotos.begin(), orthophotos.end()};
    }
    /// The scene file with all flags applied over it.
    /// @throws UsageError
    [[nodiscard]] scene::Scene scene() const;
    /// The world to open, with the scene's settings for it.
    /// @throws Error for the cache folder
    [[nodiscard]] worlds::WorldOptions options(const scene::Scene& scene) const;
    /// The same for a picture, on what the scene puts the place on.
    [[nodiscard]] worlds::WorldOptions picture_options(const scene::Scene& scene) const;
    /// The look of a picture for which nobody has chosen one: that of choose_plane(), and where no
    /// sun is asked for, neither by the scene nor by flags, it shines from the left of the camera
    /// that frames the place, at any place of the Earth.
    void choose_look(scene::Scene& scene) const;
};

/// Puts the place on a table where the camera frames it from outside, and nobody has chosen what it
/// stands on (Scene::World::plane). Other projections, and cameras with a position, show the place
/// alone.
void choose_plane(scene::Scene& scene);

/// Lets an option be given several times, with one value each time.
CLI::Option* allow_several(CLI::Option* option);

/// Help for the worlds that a command takes.
[[nodiscard]] std::string world_inputs_help();

/// Adds the flags to a command. `args` must outlive the parsing.
void add_world_arguments(CLI::App& command, WorldArguments& args);
/// The same without the inputs.
/// @param sections of the scene, or single fields of it, that are flags; empty: all of a picture
void add_opening_arguments(CLI::App& command, WorldArguments& args,
                           const std::vector<std::string>& sections);

}  // namespace terravox::commands
