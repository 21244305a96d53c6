#include "raytracer/apps/commands/arguments/programs.hpp"
#include "raytracer/apps/commands/convert/convert_command.hpp"

int main(int argc, char** argv) {
    return terravox::util::run_command_program(terravox::commands::kConvert, argc, argv,
                                               terravox::commands::add_convert_options);
}
