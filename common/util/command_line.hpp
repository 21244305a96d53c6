#pragma once

#include <initializer_list>
#include <span>
#include <string>
#include <string_view>

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
