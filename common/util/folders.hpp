#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

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

/// The folder for data that can be recomputed, but at a cost.
/// @param given  "" = $XDG_CACHE_HOME/terravox, or ~/.cache/terravox; "none" = nothing is cached;
/// else a folder
/// @return empty when nothing is cached, or when neither the variable nor a home folder exists
[[nodiscard]] std::filesystem::path cache_dir(const std::string& given);

/// A new folder in that of the system for temporary files (TMPDIR), readable by this user alone. It
/// is removed with the object. Where its process was killed, the next process of this user that
/// makes one removes it: a process holds a lock (flock) on its folders, where the file system has
/// locks. An empty path is none.
class TemporaryFolder {
public:
    TemporaryFolder() = default;
    /// @param attempt beginning of the error message: "view"
    /// @throws Error when it cannot be made
    static TemporaryFolder make(const std::string& attempt);
    TemporaryFolder(TemporaryFolder&& other) noexcept;
    TemporaryFolder& operator=(TemporaryFolder&& other) noexcept;
    ~TemporaryFolder();
    [[nodiscard]] const std::filesystem::path& path() const noexcept { return m_path; }
    /// Removes it now. A file that another thread makes meanwhile does not keep it.
    void remove() noexcept;

private:
    std::filesystem::path m_path;
    int m_lock = -1;  ///< descriptor of the folder
};

}  // namespace terravox::util
