#pragma once

#include <string>
#include <vector>

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
