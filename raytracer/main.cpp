#include <string>

#include "common/util/program.hpp"
#include "common/util/version.hpp"
#ifdef TERRAVOX_PREVIEW
#include "raytracer/commands/preview/preview_command.hpp"
#endif
#include "raytracer/commands/animate_command.hpp"
#include "raytracer/commands/cluster/cluster_command.hpp"
#include "raytracer/commands/convert_command.hpp"
#include "raytracer/commands/farm_command.hpp"
#include "raytracer/commands/merge_command.hpp"
#include "raytracer/commands/render_command.hpp"
#include "raytracer/commands/render_pool_arguments.hpp"
#include "raytracer/commands/worker_command.hpp"
#include "raytracer/commands/world_arguments.hpp"
#include "raytracer/commands/world_command.hpp"
#include "raytracer/render/picture_renderer.hpp"

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
        CLI::App app{
            "Ray traces voxel worlds: real places, Minecraft worlds, and worlds from noise.",
            "terravox"};
        app.set_version_flag("--version", std::string("terravox ") + terravox::kVersion);
        app.require_subcommand(1);
        const auto render = terravox::commands::add_render_command(app);
        const auto animate = terravox::commands::add_animate_command(app, open_renderer);
        const auto cluster = terravox::commands::add_cluster_command(app);
        const auto convert = terravox::commands::add_convert_command(app);
        const auto worker = terravox::commands::add_worker_command(app);
        const auto farm = terravox::commands::add_farm_command(app);
        const auto merge = terravox::commands::add_merge_command(app);
        const auto world = terravox::commands::add_world_command(app);
#ifdef TERRAVOX_PREVIEW
        const auto preview = terravox::commands::add_preview_command(app);
#endif
        if (const auto code = terravox::util::parse_arguments(app, argc, argv))
            return *code;
#ifdef TERRAVOX_PREVIEW
        if (app.got_subcommand("preview"))
            return static_cast<int>(preview());
#endif
        if (app.got_subcommand("animate"))
            return static_cast<int>(animate());
        if (app.got_subcommand("worker"))
            return static_cast<int>(worker());
        if (app.got_subcommand("farm"))
            return static_cast<int>(farm());
        if (app.got_subcommand("cluster"))
            return static_cast<int>(cluster());
        if (app.got_subcommand("convert"))
            return static_cast<int>(convert());
        if (app.got_subcommand("merge"))
            return static_cast<int>(merge());
        if (app.got_subcommand("world"))
            return static_cast<int>(world());
        return static_cast<int>(render());
    });
}
