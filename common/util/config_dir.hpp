#pragma once

#include <filesystem>
#include <string>

namespace terravox::util {

/// The folder of the data files that ship with the programs (class tables, materials, scenes):
/// $TERRAVOX_CONFIG when set, else `config` of the source tree that the program was built in or
/// `share/terravox/config` beside an installed program.
/// @throws Error naming every place looked at when there is none
[[nodiscard]] std::filesystem::path config_dir();

/// The ids that a folder of .toml files offers, in order: "a, b, c", for messages. Empty for a
/// folder that is not there.
[[nodiscard]] std::string toml_ids(const std::filesystem::path& folder);

/// The file that `extends = "<id>"` in `file` means: <id>.toml beside it, else the one that ships
/// in the folder `kind` of config_dir().
/// @return an empty path when there is neither
[[nodiscard]] std::filesystem::path base_file(const std::filesystem::path& file,
                                              const std::string& id, const std::string& kind);

}  // namespace terravox::util
