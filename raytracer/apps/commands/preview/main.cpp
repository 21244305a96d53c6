#include "raytracer/apps/commands/arguments/programs.hpp"
#include "raytracer/apps/commands/preview/preview_command.hpp"

int main(int argc, char** argv) {
    return terravox::util::run_command_program(terravox::commands::kPreview, argc, argv,
                                               terravox::commands::add_preview_options);
}
