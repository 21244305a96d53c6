#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace terravox::util {

/// The folder of the data files (class tables, materials, scenes): $TERRAVOX_CONFIG when set, else
/// `config` of the source tree that the program was built in, or `share/terravox/config` next to an
/// installed one; of a library with its version in its name `share/terravox/<its name>/config`.
/// @throws Error listing every place that was tried when there is none
[[nodiscard]] std::filesystem::path config_dir();

/// The ids of the .toml files in a folder, sorted. Empty when the folder does not exist.
[[nodiscard]] std::vector<std::string> toml_id_list(const std::filesystem::path& folder);
/// The same as "a, b, c", for messages.
[[nodiscard]] std::string toml_ids(const std::filesystem::path& folder);

/// Resolves `extends = "<id>"` in `file`: <id>.toml next to it, else the one that ships in the
/// folder `kind` of config_dir().
/// @return an empty path when there is neither
[[nodiscard]] std::filesystem::path base_file(const std::filesystem::path& file,
                                              const std::string& id, const std::string& kind);

}  // namespace terravox::util
