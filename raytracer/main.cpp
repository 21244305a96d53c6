#include <string>

#include "common/util/program.hpp"
#include "common/util/version.hpp"
#ifdef TERRAVOX_PREVIEW
#include "raytracer/preview/preview_command.hpp"
#endif
#include "raytracer/render/render_command.hpp"

int main(int argc, char** argv) {
    return terravox::util::run_program([&] {
        CLI::App app{"Ray traces voxel worlds: real places from LiDAR, or a voxel server.", "terravox"};
        app.set_version_flag("--version", std::string("terravox ") + terravox::kVersion);
        app.require_subcommand(1);
        const auto render = terravox::add_render_command(app);
#ifdef TERRAVOX_PREVIEW
        const auto preview = terravox::add_preview_command(app);
#endif
        if (const auto code = terravox::util::parse_arguments(app, argc, argv)) return *code;
#ifdef TERRAVOX_PREVIEW
        if (app.got_subcommand("preview")) return static_cast<int>(preview());
#endif
        return static_cast<int>(render());
    });
}
