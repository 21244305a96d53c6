#include "common/util/files.hpp"

#include <algorithm>
#include <cctype>
#include <string>

#include "common/util/error.hpp"

namespace terravox::util {

namespace fs = std::filesystem;

std::vector<fs::path> expand_folders(const std::vector<fs::path>& paths, std::initializer_list<std::string_view> endings, std::string_view what) {
    std::vector<fs::path> out;
    const auto add = [&](const fs::path& file) {
        if (std::find(out.begin(), out.end(), file) == out.end()) out.push_back(file);
    };
    for (const fs::path& path : paths) {
        std::error_code failed;
        if (!fs::exists(path, failed)) throw UsageError("open the " + std::string(what) + " " + path.string() + ": no such file or folder");
        if (!fs::is_directory(path)) {
            add(path);
            continue;
        }
        std::vector<fs::path> inside;
        for (const auto& entry : fs::directory_iterator(path, failed)) {
            std::string ending = entry.path().extension().string();
            std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
            // Names that begin with a dot are files still being written.
            if (entry.path().filename().string().front() != '.' && std::find(endings.begin(), endings.end(), ending) != endings.end()) inside.push_back(entry.path());
        }
        if (failed) throw Error("open the " + std::string(what) + " in " + path.string() + ": " + failed.message());
        if (inside.empty()) {
            std::string allowed;
            for (const auto& e : endings) allowed += (allowed.empty() ? "" : " ") + std::string(e);
            throw UsageError("open the " + std::string(what) + " in " + path.string() + ": the folder holds none of " + allowed);
        }
        std::sort(inside.begin(), inside.end());
        for (const fs::path& file : inside) add(file);
    }
    return out;
}

}  // namespace terravox::util
