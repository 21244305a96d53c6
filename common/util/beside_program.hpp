#pragma once

#include <filesystem>
#include <string_view>

namespace terravox::util {

/// A file in the folder of the running program, whether it is there or not.
[[nodiscard]] std::filesystem::path beside_program(std::string_view name);

/// Opens a shared library that lies beside the program, once however often it is asked for, and for
/// the life of the process. What it defines is not seen by others. Thread-safe.
/// @param what it is, for messages: "TLS library"
/// @return for dlsym(); never nullptr
/// @throws Error when it cannot be loaded
[[nodiscard]] void* open_beside_program(std::string_view name, std::string_view what);

}  // namespace terravox::util
