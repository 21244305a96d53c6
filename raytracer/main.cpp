#include <CLI/CLI.hpp>

#include <exception>
#include <iostream>

#include "common/util/error.hpp"
#include "common/util/version.hpp"
#ifdef TERRAVOX_PREVIEW
#include "raytracer/preview/preview_command.hpp"
#endif
#include "raytracer/render/render_command.hpp"

int main(int argc, char** argv) {
    using terravox::ExitCode;
    CLI::App app{"Ray traces voxel worlds: real places from LiDAR, or a voxel server.", "terravox"};
    app.set_version_flag("--version", std::string("terravox ") + terravox::kVersion);
    app.require_subcommand(1);
    const auto render = terravox::add_render_command(app);
#ifdef TERRAVOX_PREVIEW
    const auto preview = terravox::add_preview_command(app);
#endif
    try {
        app.parse(argc, argv);
#ifdef TERRAVOX_PREVIEW
        if (app.got_subcommand("preview")) return static_cast<int>(preview());
#endif
        return static_cast<int>(render());
    } catch (const CLI::Success& e) {  // --help and --version
        return app.exit(e);
    } catch (const CLI::ParseError& e) {
        std::cerr << "terravox: " << e.what() << "; --help lists what is allowed\n";
        return static_cast<int>(ExitCode::kUsage);
    } catch (const terravox::Error& e) {
        std::cerr << "terravox: " << e.what() << "\n";
        return static_cast<int>(e.exit_code());
    } catch (const std::bad_alloc&) {
        std::cerr << "terravox: out of memory; a smaller --memory-mib or --size may help\n";
    } catch (const std::exception& e) {
        std::cerr << "terravox: " << e.what() << "\n";
    }
    return static_cast<int>(ExitCode::kFailed);
}
