#include "voxelserver/make/worlds/luanti/world_files.hpp"

#include <fstream>
#include <map>
#include <string_view>

#include "common/util/error.hpp"

namespace terravox::luanti {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMapName = "map.sqlite";
constexpr const char* kSettingsName = "world.mt";
constexpr std::size_t kMaxSettingsBytes = std::size_t{1} << 20;

std::string_view trimmed(std::string_view text) noexcept {
    constexpr std::string_view kSpace = " \t\r";
    const auto first = text.find_first_not_of(kSpace);
    if (first == std::string_view::npos)
        return {};
    return text.substr(first, text.find_last_not_of(kSpace) - first + 1);
}

using Settings = std::map<std::string, std::string, std::less<>>;

/// The lines `key = value` of a world.mt; other lines are ignored.
Settings read_settings(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::string text(kMaxSettingsBytes + 1, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(in.gcount()));
    if (text.size() > kMaxSettingsBytes)
        throw util::Error("read the world's settings " + file.string() +
                          ": more than 1 MiB; allowed: up to that");
    if (!in.eof())
        throw util::Error("read the world's settings " + file.string() + ": it cannot be read");
    Settings out;
    for (std::string_view left = text; !left.empty();) {
        const auto end = left.find('\n');
        const std::string_view line = left.substr(0, end);
        left.remove_prefix(end == std::string_view::npos ? left.size() : end + 1);
        if (const auto equal = line.find('='); equal != std::string_view::npos)
            out[std::string(trimmed(line.substr(0, equal)))] = trimmed(line.substr(equal + 1));
    }
    return out;
}

/// @param allowed the one supported value, which is also the game's default
void check(const fs::path& folder, const Settings& settings, const char* key,
           const std::string& allowed) {
    const auto found = settings.find(key);
    if (found == settings.end() || found->second == allowed)
        return;
    throw util::UsageError("open the Luanti world " + folder.string() + ": " + key + " = " +
                           found->second + " in its world.mt; allowed: " + allowed);
}

std::string value_of(const Settings& settings, std::string_view key) {
    const auto found = settings.find(key);
    return found == settings.end() ? std::string{} : found->second;
}

std::string name_of_folder(const fs::path& folder) {
    const fs::path full = fs::absolute(folder).lexically_normal();
    return (full.has_filename() ? full : full.parent_path()).filename().string();
}

}  // namespace

bool looks_like_luanti(const fs::path& path) noexcept {
    try {
        std::error_code failed;
        if (fs::is_directory(path, failed))
            return fs::is_regular_file(path / kSettingsName, failed) &&
                   !fs::exists(path / "level.dat", failed);
        return path.filename() == kMapName && fs::is_regular_file(path, failed);
    } catch (...) {
        return false;
    }
}

WorldFiles find_world_files(const fs::path& path) {
    std::error_code failed;
    const bool is_folder = fs::is_directory(path, failed);
    const fs::path folder = is_folder ? path : fs::absolute(path).parent_path();
    Settings settings;
    if (fs::is_regular_file(folder / kSettingsName, failed))
        settings = read_settings(folder / kSettingsName);
    check(folder, settings, "blocksize", "16");
    if (is_folder)
        check(folder, settings, "backend", "sqlite3");
    WorldFiles out;
    out.map = folder / kMapName;
    out.title = value_of(settings, "world_name");
    out.game = value_of(settings, "gameid");
    if (out.title.empty())
        out.title = name_of_folder(folder);
    if (!fs::is_regular_file(out.map, failed))
        throw util::UsageError("open the Luanti world " + folder.string() +
                               ": no map.sqlite; allowed: a world that the game has saved");
    return out;
}

}  // namespace terravox::luanti
