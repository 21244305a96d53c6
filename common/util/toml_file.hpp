#pragma once

#include <toml++/toml.h>

#include <cstddef>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>

namespace terravox::util {

/// The longest text that is read as TOML.
inline constexpr std::size_t kMaxToml_bytes = std::size_t{1} << 20;

/// Reads a TOML file written by hand: settings, tables, scenes. Implausible files are refused
/// before they are parsed, so that no input takes much memory or time, or nests so deep that the
/// parser overflows the stack.
/// @param file a plain file of up to 1 MiB with up to 10,000 dots
/// @param fail called with the error, in words that follow "read the <thing> <file>: ", with the
/// line number where there is one; it must throw
/// @throws what `fail` throws
[[nodiscard]] toml::table read_toml(const std::filesystem::path& file,
                                    const std::function<void(const std::string&)>& fail);

/// Like read_toml(), for text from another source.
/// @param name for the location in an error
/// @throws what `fail` throws
[[nodiscard]] toml::table parse_toml(std::string_view text, const std::string& name,
                                     const std::function<void(const std::string&)>& fail);

/// Refuses members of a table that are none of these.
/// @param where precedes their names in messages: "[class.2] "
/// @throws what `fail` throws
void allow_only(const toml::table& table, const std::string& where,
                std::initializer_list<std::string_view> fields,
                const std::function<void(const std::string&)>& fail);

/// The file that is chosen by an id, of those in a folder of config_dir(), or by a path.
/// @param what it is, for messages: "palette"
/// @throws UsageError when there is none
[[nodiscard]] std::filesystem::path find_toml(const std::string& id_or_path, const char* folder,
                                              const char* what);

/// A value for a message about it: a text in quotes, cut after 60 bytes; numbers, true and false;
/// else its kind ("a list", "a table", "a date or time").
[[nodiscard]] std::string toml_value(const toml::node& node);

}  // namespace terravox::util
