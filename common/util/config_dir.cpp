#include "common/util/config_dir.hpp"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include "common/util/beside_program.hpp"
#include "common/util/error.hpp"

namespace terravox::util {

std::filesystem::path config_dir() {
    namespace fs = std::filesystem;
    const auto holds_config = [](const fs::path& p) {
        std::error_code ignored;
        return fs::is_regular_file(p / "materials.toml", ignored);
    };
    if (const char* folder = std::getenv("TERRAVOX_CONFIG"); folder != nullptr && *folder != '\0') {
        if (holds_config(folder))
            return folder;
        throw UsageError("find the configuration: TERRAVOX_CONFIG = '" + std::string(folder) +
                         "' holds no materials.toml");
    }
    const fs::path program = own_file();
    std::vector<fs::path> places{"config", "share/terravox/config"};
    if (has_version(program))
        places.insert(places.begin() + 1, "share/terravox" / program.filename() / "config");
    std::string tried;
    fs::path folder = program.parent_path();
    // build/<preset>/bin is three levels below the root of the sources; an installed bin/ is one
    // below its prefix.
    for (int up = 0; up < 5 && !folder.empty(); ++up, folder = folder.parent_path())
        for (const fs::path& place : places) {
            const fs::path candidate = folder / place;
            if (holds_config(candidate))
                return candidate;
            tried += (tried.empty() ? "" : ", ") + candidate.string();
        }
    throw Error("find the configuration: no materials.toml in " + tried + "; set TERRAVOX_CONFIG");
}

std::vector<std::string> toml_id_list(const std::filesystem::path& folder) {
    std::vector<std::string> ids;
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
        if (entry.path().extension() == ".toml")
            ids.push_back(entry.path().stem().string());
    std::sort(ids.begin(), ids.end());
    return ids;
}

std::string toml_ids(const std::filesystem::path& folder) {
    std::string out;
    for (const auto& id : toml_id_list(folder))
        out += (out.empty() ? "" : ", ") + id;
    return out;
}

std::filesystem::path base_file(const std::filesystem::path& file, const std::string& id,
                                const std::string& kind) {
    const std::string name = id + ".toml";
    std::error_code ignored;
    if (auto neighbour = file.parent_path() / name; std::filesystem::exists(neighbour, ignored))
        return neighbour;
    if (auto shipped = config_dir() / kind / name; std::filesystem::exists(shipped, ignored))
        return shipped;
    return {};
}

}  // namespace terravox::util
