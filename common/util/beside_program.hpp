#pragma once

#include <filesystem>
#include <string_view>

namespace terravox::util {

/// @return the file that this code is in: the running program, or a shared library that is a part
/// of another one; links are followed. Empty when the system does not tell
[[nodiscard]] std::filesystem::path own_file();

/// @return the path of a file in the folder of own_file(); it need not exist
[[nodiscard]] std::filesystem::path beside_program(std::string_view name);

/// Loads a shared library from the folder of the program, once per process however often it is
/// requested; it is never unloaded. Its symbols are not visible to other libraries. Thread-safe.
/// @param what what the library is, for messages: "TLS library"
/// @return a handle for dlsym(); never nullptr
/// @throws Error when it cannot be loaded
[[nodiscard]] void* open_beside_program(std::string_view name, std::string_view what);

}  // namespace terravox::util
