#pragma once

#include <filesystem>
#include <string_view>

namespace terravox::util {

/// @return the file that this code is in: the running program, or a shared library that is a part
/// of another one; links are followed. Empty when the system does not tell
[[nodiscard]] std::filesystem::path own_file();

/// @return the path of a file in the folder of own_file(); it need not exist
[[nodiscard]] std::filesystem::path beside_program(std::string_view name);

/// @return whether a file is a library with its version in its name, libterravox.so.0.1.0: several
/// of them can be installed next to each other, and each has files of its own
[[nodiscard]] bool has_version(const std::filesystem::path& library);

/// @return the path of a module; it need not exist. It lies in the folder of own_file(), but that
/// of a library with a version in terravox/libterravox.so.0.1.0 there
[[nodiscard]] std::filesystem::path module_file(std::string_view name);

/// Loads a module, once per process however often it is requested; it is never unloaded. Its
/// symbols are not visible to other libraries. Thread-safe.
/// @param what what the library is, for messages: "TLS library"
/// @return a handle for dlsym(); never nullptr
/// @throws Error when it cannot be loaded
[[nodiscard]] void* open_module(std::string_view name, std::string_view what);

}  // namespace terravox::util
