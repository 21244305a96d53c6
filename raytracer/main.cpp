#include <string>

#include "common/util/program.hpp"
#include "common/util/version.hpp"
#include "raytracer/apps/commands/analyse/analyse_command.hpp"
#include "raytracer/apps/commands/arguments/programs.hpp"
#include "raytracer/apps/commands/arguments/world_arguments.hpp"
#include "raytracer/apps/commands/cluster/cluster_command.hpp"
#include "raytracer/apps/commands/commands.hpp"
#include "raytracer/apps/commands/country/country_command.hpp"
#include "raytracer/apps/commands/map/map_command.hpp"
#include "raytracer/apps/commands/merge/merge_command.hpp"
#include "raytracer/apps/commands/run_arguments.hpp"
#include "raytracer/farm/render/picture_renderer.hpp"

namespace {

terravox::animate::RenderPicture open_renderer(
    const terravox::commands::WorldArguments& world,
    const terravox::commands::RenderPoolArguments& render_pool, const terravox::scene::Scene& base,
    bool quiet) {
    const auto renderer = std::make_shared<terravox::render::PictureRenderer>(
        world.options(base), render_pool.options(base), base, quiet);
    return [renderer](const terravox::scene::Scene& scene, const std::filesystem::path& picture) {
        const std::vector<std::string> files{picture.string()};
        terravox::render::PictureRenderer::check(scene, files);
        return renderer->render(scene, files).has_holes() ? terravox::util::ExitCode::kHoles
                                                          : terravox::util::ExitCode::kDone;
    };
}

}  // namespace

int main(int argc, char** argv) {
    return terravox::util::run_program([&] {
        terravox::util::go_on_as(terravox::commands::kConvert, argc, argv);
        terravox::util::go_on_as(terravox::commands::kPublish, argc, argv);
        terravox::util::go_on_as(terravox::commands::kView, argc, argv);
#ifdef TERRAVOX_PREVIEW
        terravox::util::go_on_as(terravox::commands::kPreview, argc, argv);
#endif
        CLI::App app{
            "Ray traces voxel worlds: real places, Minecraft worlds, and worlds from noise.",
            "terravox"};
        app.set_version_flag("--version", std::string("terravox ") + terravox::kVersion);
        app.require_subcommand(1);
        const auto render = terravox::commands::add_render_command(app);
        const auto animate = terravox::commands::add_animate_command(app, open_renderer);
        const auto analyse = terravox::commands::add_analyse_command(app);
        const auto map = terravox::commands::add_map_command(app);
        const auto cluster = terravox::commands::add_cluster_command(app);
        const auto country = terravox::commands::add_country_command(app);
        terravox::util::list_command(app, terravox::commands::kConvert);
        terravox::util::list_command(app, terravox::commands::kPublish);
        terravox::util::list_command(app, terravox::commands::kView);
        const auto worker = terravox::commands::add_worker_command(app);
        const auto farm = terravox::commands::add_farm_command(app);
        const auto merge = terravox::commands::add_merge_command(app);
        const auto world = terravox::commands::add_world_command(app);
#ifdef TERRAVOX_PREVIEW
        terravox::util::list_command(app, terravox::commands::kPreview);
#endif
        if (const auto code = terravox::util::parse_arguments(app, argc, argv))
            return *code;
        if (app.got_subcommand("animate"))
            return static_cast<int>(animate());
        if (app.got_subcommand("analyse"))
            return static_cast<int>(analyse());
        if (app.got_subcommand("map"))
            return static_cast<int>(map());
        if (app.got_subcommand("worker"))
            return static_cast<int>(worker());
        if (app.got_subcommand("farm"))
            return static_cast<int>(farm());
        if (app.got_subcommand("cluster"))
            return static_cast<int>(cluster());
        if (app.got_subcommand("country"))
            return static_cast<int>(country());
        if (app.got_subcommand("merge"))
            return static_cast<int>(merge());
        if (app.got_subcommand("world"))
            return static_cast<int>(world());
        if (app.got_subcommand("render"))
            return static_cast<int>(render());
        throw terravox::util::UsageError("a command that is a program of its own must come first");
    });
}
