#pragma once

#include <filesystem>
#include <string>

namespace terravox::util {

/// The folder of the data files that ship with the programs (class tables, materials, scenes): $TERRAVOX_CONFIG when set, else
/// `config` of the source tree that the program was built in or `share/terravox/config` beside an installed program.
/// @throws Error naming every place looked at when there is none
[[nodiscard]] std::filesystem::path config_dir();

/// The ids that a folder of .toml files offers, in order: "a, b, c", for messages. Empty for a folder that is not there.
[[nodiscard]] std::string toml_ids(const std::filesystem::path& folder);

}  // namespace terravox::util
