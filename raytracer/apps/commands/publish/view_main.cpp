#include "raytracer/apps/commands/arguments/programs.hpp"
#include "raytracer/apps/commands/publish/site_commands.hpp"

int main(int argc, char** argv) {
    return terravox::util::run_command_program(terravox::commands::kView, argc, argv,
                                               terravox::commands::add_view_options);
}
