#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// A command that is a program of its own next to terravox-raytracer, since it alone needs a window
/// or the libraries of other programs' formats: pictures start without them.
struct CommandWithProgram {
    const char* name;         ///< of the command
    const char* program;      ///< the file, in the folder of the others
    const char* description;  ///< for --help
};
inline constexpr CommandWithProgram kConvert{
    "convert", "terravox-convert",
    "Convert a world to a box archive, a Minecraft world, or another program's format"};
inline constexpr CommandWithProgram kPublish{
    "publish", "terravox-publish",
    "Make a web site of a world, which any static host serves and any browser shows"};
inline constexpr CommandWithProgram kView{
    "view", "terravox-view", "Show a site, or a world as one, to a browser of this machine"};
inline constexpr CommandWithProgram kPreview{
    "preview", "terravox-preview",
    "Fly around a world in a window while it is rendered, coarse to fine"};

/// Adds the options of a command to its program.
/// @return runs the command once the arguments are parsed
using AddOptions = std::function<std::function<util::ExitCode()>(CLI::App&)>;

/// The whole of such a program: parses its arguments and runs the command.
/// @return the exit code
[[nodiscard]] int run_program_of(const CommandWithProgram& command, int argc, char** argv,
                                 const AddOptions& add_options);

/// Adds a command to what --help of this program lists.
void list_command(CLI::App& app, const CommandWithProgram& command);

/// Where the first argument is the command's name, goes on as its program, with the arguments that
/// follow; else returns.
/// @throws Error when the program cannot be started
void go_on_as(const CommandWithProgram& command, int argc, char** argv);

}  // namespace terravox::commands
