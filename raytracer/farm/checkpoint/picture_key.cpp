#include "raytracer/farm/checkpoint/picture_key.hpp"

#include <xxhash.h>
#include <array>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/util/build_id.hpp"
#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/json_text.hpp"
#include "common/util/version.hpp"
#include "raytracer/core/material/appearance.hpp"
#include "raytracer/core/scene/scene_io.hpp"

namespace terravox::farm {
namespace {

using nlohmann::json;
using Fields = std::map<std::string, std::string>;

constexpr std::int64_t kLargest_px = 65'536;
constexpr std::int64_t kMaxTiles = std::int64_t{1} << 20;

/// "camera.fov_deg" -> "40.0", without the comments.
Fields fields_of_scene(const std::string& toml) {
    Fields out;
    std::istringstream in(toml);
    std::string section;
    for (std::string line; std::getline(in, line);) {
        if (line.starts_with('[') && line.ends_with(']'))
            section = line.substr(1, line.size() - 2) + ".";
        const auto equals = line.find(" = ");
        if (equals == std::string::npos || line.starts_with('['))
            continue;
        std::string value = line.substr(equals + 3);
        if (const auto comment = value.rfind("  # "); comment != std::string::npos)
            value.resize(comment);
        out[section + line.substr(0, equals)] = value;
    }
    return out;
}

Fields fields_of_world(const std::string& text) {
    Fields out;
    const json world = util::parse_json(text);
    if (!world.is_object())
        return {{"world", text}};
    for (const auto& [name, value] : world.items())
        out["world." + name] = value.dump();
    return out;
}

/// For long texts (a CRS), one line can only state that they differ.
std::string shown(const Fields& fields, const std::string& name) {
    constexpr std::size_t kMaxLetters = 60;
    const auto found = fields.find(name);
    if (found == fields.end())
        return "not set";
    return found->second.size() > kMaxLetters ? found->second.substr(0, kMaxLetters) + "..."
                                              : found->second;
}

std::string differing(const Fields& there, const Fields& here) {
    constexpr int kMaxNamed = 3;
    Fields all = there;
    all.insert(here.begin(), here.end());
    std::string out;
    int differ = 0;
    for (const auto& [name, unused] : all) {
        const auto a = there.find(name);
        const auto b = here.find(name);
        if (a != there.end() && b != here.end() && a->second == b->second)
            continue;
        if (++differ <= kMaxNamed)
            out += (out.empty() ? "" : ", ") + name + " = " + shown(there, name) + " there, " +
                   shown(here, name) + " here";
    }
    return out +
           (differ > kMaxNamed ? ", and " + std::to_string(differ - kMaxNamed) + " more" : "");
}

Fields fields_of_inputs(const std::vector<std::string>& inputs) {
    Fields out;
    for (std::size_t i = 0; i < inputs.size(); ++i)
        out["input " + std::to_string(i + 1)] = inputs[i];
    return out;
}

}  // namespace

std::string PictureKey::to_json() const {
    const json out = {{"software", software},    {"build", build},
                      {"scene", scene},          {"world", world},
                      {"inputs", inputs},        {"size_px", {grid.width_px, grid.height_px}},
                      {"tile_px", grid.tile_px}, {"layers", with_layers}};
    return out.dump(-1, ' ', false, json::error_handler_t::replace);
}

PictureKey PictureKey::from_json(const std::string& text, const std::string& origin) {
    PictureKey out;
    try {
        const json in = util::parse_json(text);
        if (in.is_discarded())
            throw util::Error("read the checkpoint " + origin +
                              ": what it is of cannot be understood: it is no JSON");
        out.software = in.at("software").get<std::string>();
        out.build = in.at("build").get<std::string>();
        out.scene = in.at("scene").get<std::string>();
        out.world = in.at("world").get<std::string>();
        out.inputs = in.at("inputs").get<std::vector<std::string>>();
        const auto size = in.at("size_px").get<std::vector<std::int64_t>>();
        const auto tile = in.at("tile_px").get<std::int64_t>();
        out.with_layers = in.at("layers").get<bool>();
        if (size.size() != 2)
            throw util::Error("read the checkpoint " + origin + ": a picture of " +
                              std::to_string(size.size()) + " sizes; allowed: 2, width and height");
        for (const std::int64_t edge : size)
            if (edge < 1 || edge > kLargest_px)
                throw util::Error("read the checkpoint " + origin + ": a picture of " +
                                  std::to_string(edge) + " pixels; allowed: 1 to 65536");
        if (tile < 1 || tile > scene::TileSize::kMax_px)
            throw util::Error("read the checkpoint " + origin + ": tiles of " +
                              std::to_string(tile) + " pixels; allowed: 1 to 4096");
        out.grid = {static_cast<int>(size[0]), static_cast<int>(size[1]), static_cast<int>(tile)};
    } catch (const json::exception& e) {
        throw util::Error("read the checkpoint " + origin +
                          ": what it is of cannot be understood: " + e.what());
    }
    if (const std::int64_t tiles = std::int64_t{out.grid.columns()} * out.grid.rows();
        tiles > kMaxTiles)
        throw util::Error("read the checkpoint " + origin + ": " + std::to_string(tiles) +
                          " tiles; allowed: up to " + std::to_string(kMaxTiles));
    return out;
}

PictureKey to_key(const scene::Scene& scene, const voxel::WorldInfo& world,
                  std::vector<std::string> inputs) {
    PictureKey out;
    out.software = std::string("terravox ") + kVersion;
    out.build = kBuild;
    out.scene = scene::to_toml(scene::what_shows(scene));
    out.world = voxel::world_to_json(world);
    out.inputs = std::move(inputs);
    const auto [width, height] = scene.output.size_px;
    out.grid = {width, height, scene.quality.tile.in_picture(width)};
    out.with_layers = scene.output.layers != core::PictureLayers::kBeauty || scene.output.denoise;
    return out;
}

std::string difference(const PictureKey& there, const PictureKey& here) {
    if (there == here)
        return {};
    if (there.software != here.software || there.build != here.build)
        return "made by " + there.software + ", build " + there.build + "; this is " +
               here.software + ", build " + here.build;
    if (const std::string scene =
            differing(fields_of_scene(there.scene), fields_of_scene(here.scene));
        !scene.empty())
        return scene;
    // Before the world: its facts follow from what it was made of.
    if (const std::string inputs =
            differing(fields_of_inputs(there.inputs), fields_of_inputs(here.inputs));
        !inputs.empty())
        return inputs;
    if (const std::string world =
            differing(fields_of_world(there.world), fields_of_world(here.world));
        !world.empty())
        return world;
    if (there.grid != here.grid)
        return "tiles of " + std::to_string(there.grid.tile_px) + " pixels there, " +
               std::to_string(here.grid.tile_px) + " here";
    if (there.with_layers != here.with_layers)
        return there.with_layers ? "layers there, none here" : "no layers there, layers here";
    return "scene or world written in another way";
}

namespace {

namespace fs = std::filesystem;

/// Files that a program writes next to its data while they are open, and hidden files.
bool is_passing(const std::string& name) {
    constexpr std::array kEndings = {".lock", "-wal", "-shm", "-journal"};
    return name.starts_with('.') ||
           std::any_of(kEndings.begin(), kEndings.end(),
                       [&](const char* ending) { return name.ends_with(ending); });
}

[[noreturn]] void fail_to_name(const fs::path& file, const std::string& what) {
    throw util::Error("name the inputs of the picture: " + file.string() + ": " + what);
}

class Contents {
public:
    /// @param as the file's name relative to the input
    void add(const fs::path& file, const std::string& as) {
        constexpr std::uint64_t kSample_bytes = 16'384;
        std::error_code failed;
        const std::uint64_t size = fs::file_size(file, failed);
        std::ifstream in(file, std::ios::binary);
        if (failed || !in)
            fail_to_name(file, "cannot be read");
        take(as.data(), as.size());
        take(&size, sizeof size);
        std::vector<char> sample(std::min(size, kSample_bytes));
        for (const std::uint64_t at : {std::uint64_t{0}, size - sample.size()}) {
            in.seekg(static_cast<std::streamoff>(at));
            if (!in.read(sample.data(), static_cast<std::streamsize>(sample.size())))
                fail_to_name(file, "cannot be read");
            take(sample.data(), sample.size());
        }
        ++m_files;
        m_bytes += size;
    }
    [[nodiscard]] std::string text() const {
        return fmt::format("{} {}, {} bytes, {:016x}", m_files, m_files == 1 ? "file" : "files",
                           m_bytes, m_hash);
    }

private:
    void take(const void* bytes, std::size_t count) noexcept {
        m_hash = XXH3_64bits_withSeed(bytes, count, m_hash);
    }
    std::uint64_t m_files = 0;
    std::uint64_t m_bytes = 0;
    std::uint64_t m_hash = 0;
};

void add_all(Contents& contents, const fs::path& path, const IsOutput& is_output = {}) {
    std::error_code failed;
    if (!fs::is_directory(path, failed))
        return contents.add(path, path.filename().string());
    const fs::path root = is_output ? fs::canonical(path, failed) : path;
    const auto counts = [&](const fs::path& file) {
        return !is_output || !is_output(root / file.lexically_relative(path));
    };
    std::vector<fs::path> files;
    for (fs::recursive_directory_iterator
             it(path, fs::directory_options::follow_directory_symlink, failed),
         end;
         !failed && it != end; it.increment(failed)) {
        const std::string name = it->path().filename().string();
        std::error_code ignored;
        if (is_passing(name))
            it.disable_recursion_pending();
        else if (it->is_regular_file(ignored) && counts(it->path()))
            files.push_back(it->path());
    }
    if (failed)
        fail_to_name(path, failed.message());
    std::sort(files.begin(), files.end());
    for (const fs::path& file : files)
        contents.add(file, file.lexically_relative(path).string());
}

std::string to_name(const fs::path& path, const IsOutput& is_output) {
    Contents contents;
    add_all(contents, path, is_output);
    const fs::path bare = path.has_filename() ? path : path.parent_path();
    return bare.filename().string() + ": " + contents.text();
}

}  // namespace

std::vector<std::string> name_inputs(const std::vector<std::string>& inputs,
                                     const std::vector<fs::path>& orthophotos,
                                     const scene::Scene& scene, const IsOutput& is_output) {
    std::vector<std::string> out;
    std::error_code ignored;
    for (const std::string& input : inputs)
        out.push_back(fs::exists(input, ignored) ? to_name(input, is_output) : input);
    for (const fs::path& photo : orthophotos)
        out.push_back("orthophoto " +
                      (fs::exists(photo, ignored) ? to_name(photo, is_output) : photo.string()));
    Contents shaping;
    add_all(shaping, material::find_materials(scene.quality.materials));
    for (const char* data : {"blocks", "classes", "palettes", "voxelize.toml"})
        if (const fs::path path = util::config_dir() / data; fs::exists(path, ignored))
            add_all(shaping, path);
    for (const std::string& given : {scene.world.settings, scene.world.classes})
        if (!given.empty() && fs::is_regular_file(given, ignored))
            add_all(shaping, given);
    out.push_back("configuration: " + shaping.text());
    return out;
}

}  // namespace terravox::farm
