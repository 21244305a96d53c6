#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "common/util/program.hpp"
#include "common/util/version.hpp"
#include "raytracer/apps/commands/analyse/analyse_run.hpp"
#include "raytracer/apps/commands/arguments/programs.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/apps/commands/cluster/cluster_command.hpp"
#include "raytracer/apps/commands/commands.hpp"
#include "raytracer/apps/commands/country/country_command.hpp"
#include "raytracer/apps/commands/run_arguments.hpp"
#include "raytracer/farm/render/picture_renderer.hpp"

namespace {

namespace commands = terravox::commands;
using terravox::util::ExitCode;

terravox::animate::RenderPicture open_renderer(const commands::WorldArguments& world,
                                               const commands::RenderPoolArguments& render_pool,
                                               const terravox::scene::Scene& base, bool quiet) {
    const auto renderer = std::make_shared<terravox::render::PictureRenderer>(
        world.picture_options(base), render_pool.options(base), base, quiet);
    return [renderer](const terravox::scene::Scene& scene, const std::filesystem::path& picture) {
        const std::vector<std::string> files{picture.string()};
        terravox::render::PictureRenderer::check(scene, files);
        return renderer->render(scene, files).has_holes() ? ExitCode::kHoles : ExitCode::kDone;
    };
}

}  // namespace

int main(int argc, char** argv) {
    return terravox::util::run_program([&] {
        terravox::util::go_on_as(commands::kConvert, argc, argv);
        terravox::util::go_on_as(commands::kPublish, argc, argv);
        terravox::util::go_on_as(commands::kView, argc, argv);
#ifdef TERRAVOX_PREVIEW
        terravox::util::go_on_as(commands::kPreview, argc, argv);
#endif
        CLI::App app{
            "Ray traces voxel worlds: real places, Minecraft worlds, and worlds from noise.",
            "terravox"};
        app.set_version_flag("--version", std::string("terravox ") + terravox::kVersion);
        app.require_subcommand(1);
        std::vector<std::pair<const char*, std::function<ExitCode()>>> here;
        here.emplace_back("render", commands::add_render_command(app));
        here.emplace_back("animate", commands::add_animate_command(app, open_renderer));
        here.emplace_back("analyse", commands::add_analyse_command(app));
        here.emplace_back("map", commands::add_map_command(app));
        here.emplace_back("cluster", commands::add_cluster_command(app));
        here.emplace_back("country", commands::add_country_command(app));
        terravox::util::list_command(app, commands::kConvert);
        terravox::util::list_command(app, commands::kPublish);
        terravox::util::list_command(app, commands::kView);
        here.emplace_back("worker", commands::add_worker_command(app));
        here.emplace_back("farm", commands::add_farm_command(app));
        here.emplace_back("merge", commands::add_merge_command(app));
        here.emplace_back("world", commands::add_world_command(app));
#ifdef TERRAVOX_PREVIEW
        terravox::util::list_command(app, commands::kPreview);
#endif
        if (const auto code = terravox::util::parse_arguments(app, argc, argv))
            return *code;
        for (const auto& [name, run] : here)
            if (app.got_subcommand(name))
                return static_cast<int>(run());
        throw terravox::util::UsageError("a command that is a program of its own must come first");
    });
}
