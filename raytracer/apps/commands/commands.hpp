#pragma once

#include <functional>

#include "common/util/error.hpp"
#include "raytracer/core/animate/render_frames.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

// Each adds a command to the program's.
// @return runs the command once the arguments are parsed
// @throws (when run) Error, UsageError
/// `farm token` and `farm certs` (how coordinators and workers know each other), `farm status`
/// (what a daemon or a coordinator is doing), `farm pause` and `farm resume`.
[[nodiscard]] std::function<util::ExitCode()> add_farm_command(CLI::App& app);
/// A world from above, as a GeoTIFF or as tiles for the web.
[[nodiscard]] std::function<util::ExitCode()> add_map_command(CLI::App& app);
[[nodiscard]] std::function<util::ExitCode()> add_merge_command(CLI::App& app);
[[nodiscard]] std::function<util::ExitCode()> add_render_command(CLI::App& app);
/// The daemon that lends this machine to renders on other machines.
[[nodiscard]] std::function<util::ExitCode()> add_worker_command(CLI::App& app);
/// `world info`.
[[nodiscard]] std::function<util::ExitCode()> add_world_command(CLI::App& app);

struct RenderPoolArguments;
struct WorldArguments;

/// Opens the world of the arguments once and returns the function that renders its pictures.
/// @param render_pool what renders: threads, workers
/// @param base the scene that all frames share: its world, size and processing apply to every frame
/// @param quiet print nothing but errors
using OpenRenderer = std::function<animate::RenderPicture(const WorldArguments& world,
                                                          const RenderPoolArguments& render_pool,
                                                          const scene::Scene& base, bool quiet)>;
[[nodiscard]] std::function<util::ExitCode()> add_animate_command(CLI::App& app, OpenRenderer open);

}  // namespace terravox::commands
