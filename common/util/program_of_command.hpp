#pragma once

#include <functional>

#include "common/util/error.hpp"

namespace CLI {
class App;
}

namespace terravox::util {

/// A command that is a program of its own next to the one that lists it, since it alone needs a
/// window, GDAL or the libraries of other programs' formats: the other commands start without them.
struct CommandWithProgram {
    const char* name;                    ///< of the command
    const char* program;                 ///< the file, in the folder of the others
    const char* description;             ///< for --help
    const char* listed_by = "terravox";  ///< how a user calls the program that lists it
};

/// Adds the options of a command to its program.
/// @return runs the command once the arguments are parsed
using AddOptions = std::function<std::function<ExitCode()>(CLI::App&)>;

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

}  // namespace terravox::util
