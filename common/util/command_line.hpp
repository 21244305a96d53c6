#pragma once

#include <functional>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/util/error.hpp"

namespace CLI {
class App;
class ParseError;
}  // namespace CLI

namespace terravox::util {

// What programs answer about their command lines: help, and why arguments are refused.

/// Lists options in the first group of the help. A command that has such a group prints nothing but
/// its arguments and these with --help, and the rest with --help GROUP and --help all.
/// @param names as they are typed ("--size"), of options that the command has
void list_first(CLI::App& command, std::initializer_list<const char*> names);

/// Refuses an option that the command had in an earlier version; no help lists it.
/// @param name as it is typed ("--discover"); it had no value
/// @param instead what serves now, for the end of a message
void refuse_removed_option(CLI::App& command, const std::string& name, const std::string& instead);

/// What --help prints of the command that was reached: the program itself, or the innermost of its
/// subcommands on the command line.
/// @param arguments of the program, without its name: the word after --help chooses the group
/// @throws UsageError for a word that is no group, where the command has groups to choose from
[[nodiscard]] std::string help_text(const CLI::App& app, std::span<const char* const> arguments);

/// Refuses what would be read as something else: a long option with one hyphen ("-output" is -o
/// with the value "utput"), and an option as the value of another ("--size --samples 4").
/// @throws UsageError
void refuse_misread_arguments(const CLI::App& app, std::span<const char* const> arguments);

/// Why arguments are refused, in one line: with what was probably meant, or what is allowed, and
/// options as they were typed.
[[nodiscard]] std::string usage_message(const CLI::App& app, const CLI::ParseError& error,
                                        std::span<const char* const> arguments);

}  // namespace terravox::util

namespace CLI {
class App;
class Option;
}  // namespace CLI

namespace terravox::util {

/// True for the command line `PROGRAM --option-tables`, which no help lists: man pages and
/// completions are made of what it prints (config/manual).
[[nodiscard]] bool wants_option_tables(int argc, const char* const* argv);

/// @return what --help says of a program and its subcommands, as JSON that ends with a line end: an
///         object with `name`, `description`, `footer`, `options`, `commands` (objects like it).
///         An option has
///         - `names` ("--size", "-o"; none of a positional one) and `positional` (its name, or "")
///         - `group`, `text`, `default` (or ""), `required`, `repeats` (takes several values)
///         - `value` ("TEXT"; "" of a flag that takes none) and `words` (all values, or none)
[[nodiscard]] std::string option_tables(const CLI::App& app);

/// All values of an option, where its type or its help lists them.
[[nodiscard]] std::vector<std::string> find_value_words(const CLI::Option& option);

}  // namespace terravox::util

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
[[nodiscard]] int run_command_program(const CommandWithProgram& command, int argc, char** argv,
                                      const AddOptions& add_options);

/// Adds a command to what --help of this program lists.
void list_command(CLI::App& app, const CommandWithProgram& command);

/// Where the first argument is the command's name, goes on as its program, with the arguments that
/// follow; else returns.
/// @throws Error when the program cannot be started
void go_on_as(const CommandWithProgram& command, int argc, char** argv);

}  // namespace terravox::util
