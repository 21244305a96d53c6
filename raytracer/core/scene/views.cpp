#include "raytracer/core/scene/views.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/text.hpp"
#include "common/util/toml_file.hpp"
#include "raytracer/core/scene/scene_io.hpp"

namespace terravox::scene {
namespace {

// U+00C0 to U+017F: Latin-1 has its small letters 32 later, Latin Extended-A one later, where
// capitals are even or odd by stretches.
unsigned small_letter(unsigned c) {
    if (c >= 0xC0 && c <= 0xDE && c != 0xD7)
        return c + 32;
    const bool even_capitals = (c >= 0x100 && c <= 0x137) || (c >= 0x14A && c <= 0x177);
    const bool odd_capitals = (c >= 0x139 && c <= 0x148) || (c >= 0x179 && c <= 0x17E);
    if ((even_capitals && c % 2 == 0) || (odd_capitals && c % 2 == 1))
        return c + 1;
    return c;
}

}  // namespace

std::string folded(const std::string& name) {
    std::string out;
    bool apart = false;
    const auto add = [&](char c) {
        if (apart && !out.empty())
            out += ' ';
        apart = false;
        out += c;
    };
    for (std::size_t i = 0; i < name.size(); ++i) {
        const auto byte = static_cast<unsigned char>(name[i]);
        if (byte == ' ' || byte == '-' || byte == '_' || byte == '\t')
            apart = true;
        else if (byte >= 'A' && byte <= 'Z')
            add(static_cast<char>(byte - 'A' + 'a'));
        else if (byte >= 0xC3 && byte <= 0xC5 && i + 1 < name.size() &&
                 (static_cast<unsigned char>(name[i + 1]) & 0xC0) == 0x80) {
            const unsigned letter =
                small_letter((byte & 0x1FU) << 6 | (static_cast<unsigned char>(name[++i]) & 0x3FU));
            add(static_cast<char>(0xC0 | letter >> 6));
            add(static_cast<char>(0x80 | (letter & 0x3F)));
        } else
            add(name[i]);
    }
    return out;
}

std::vector<std::string> near_names(const std::string& asked, const std::vector<std::string>& names,
                                    std::size_t max) {
    constexpr std::size_t kLongest = 200;  // longer than any name: not worth the time
    const std::string wanted = folded(asked);
    std::vector<std::pair<std::size_t, std::string>> near;
    if (wanted.empty() || wanted.size() > kLongest)
        return {};
    for (const std::string& name : names) {
        const std::string known = folded(name);
        const std::size_t distance = util::edit_distance(wanted, known);
        const bool holds =
            wanted.size() >= 3 && known.size() >= 3 &&
            (known.find(wanted) != std::string::npos || wanted.find(known) != std::string::npos);
        if (holds || distance <= std::max<std::size_t>(2, known.size() / 3))
            near.emplace_back(distance, name);
    }
    std::sort(near.begin(), near.end());
    std::vector<std::string> out;
    for (std::size_t i = 0; i < std::min(max, near.size()); ++i)
        out.push_back(near[i].second);
    return out;
}

namespace {

constexpr int kViewsVersion = 1;

std::string text_in(const toml::table& table, const char* key, const std::string& attempt,
                    bool needed) {
    const auto* node = table.get(key);
    if (node == nullptr && !needed)
        return {};
    const auto text =
        node == nullptr ? std::optional<std::string>{} : node->value_exact<std::string>();
    if (!text || (needed && folded(*text).empty()))
        throw util::UsageError(attempt + ": " + key + " = " +
                               (node == nullptr ? "nothing" : "no name") +
                               "; allowed: text in quotes");
    return *text;
}

NamedView read_view(const toml::node& node, const std::filesystem::path& file,
                    std::string attempt) {
    const auto* table = node.as_table();
    if (table == nullptr)
        throw util::UsageError(attempt + ": view = " + util::toml_value(node) +
                               "; allowed: [[view]]");
    NamedView out;
    out.file = file;
    out.fields = *table;
    out.name = text_in(*table, "name", attempt, true);
    attempt += ": view '" + out.name + "'";
    out.title = text_in(*table, "title", attempt, false);
    out.area = text_in(*table, "area", attempt, false);
    if (const auto* aliases = table->get("aliases")) {
        if (!aliases->is_array())
            throw util::UsageError(attempt + ": aliases = " + util::toml_value(*aliases) +
                                   "; allowed: a list of texts");
        for (const auto& alias : *aliases->as_array()) {
            const auto text = alias.value_exact<std::string>();
            if (!text || folded(*text).empty())
                throw util::UsageError(
                    attempt +
                    ": aliases = a list with other values than names; allowed: a list of texts");
            out.aliases.push_back(*text);
        }
    }
    for (const char* key : {"name", "title", "area", "aliases"})
        out.fields.erase(key);
    Scene checked;
    read_scene_table(out.fields, attempt, checked);
    if (!checked.camera.look.empty())
        throw util::UsageError(attempt + ": camera.look = '" + checked.camera.look +
                               "'; allowed: none, a view does not build upon another");
    return out;
}

[[noreturn]] void refuse_look(const std::string& look, const std::vector<NamedView>& views,
                              const std::filesystem::path& folder) {
    constexpr std::size_t kMax = 30;
    std::vector<std::string> names;
    std::vector<std::string> all;
    for (const NamedView& view : views) {
        all.push_back(view.name);
        names.push_back(view.name);
        names.insert(names.end(), view.aliases.begin(), view.aliases.end());
    }
    const std::string attempt = "place the camera: camera.look = '" + look + "' names no view";
    if (all.empty())
        throw util::UsageError(attempt + "; there is none in " + folder.string());
    if (const auto near = near_names(look, names); !near.empty())
        throw util::UsageError(attempt + util::did_you_mean(near));
    std::sort(all.begin(), all.end());
    if (all.size() > kMax) {
        all.resize(kMax);
        all.emplace_back("...");
    }
    throw util::UsageError(attempt + "; allowed: " + util::comma_list(all));
}

bool is_called(const NamedView& view, const std::string& wanted) {
    return folded(view.name) == wanted ||
           std::any_of(view.aliases.begin(), view.aliases.end(),
                       [&](const std::string& alias) { return folded(alias) == wanted; });
}

}  // namespace

std::vector<NamedView> read_views(const std::filesystem::path& file) {
    const std::string attempt = "read the views " + file.string();
    const toml::table root = util::read_toml(
        file, [&](const std::string& what) { throw util::UsageError(attempt + ": " + what); });
    std::vector<NamedView> out;
    for (const auto& [key, node] : root) {
        if (key.str() == "version") {
            if (node.value_exact<std::int64_t>() != kViewsVersion)
                throw util::UsageError(attempt + ": version = " + util::toml_value(node) +
                                       "; allowed: " + std::to_string(kViewsVersion));
        } else if (key.str() == "view" && node.is_array()) {
            for (const auto& view : *node.as_array())
                out.push_back(read_view(view, file, attempt));
        } else
            throw util::UsageError(attempt + ": unknown field '" + std::string(key.str()) +
                                   "'; allowed: version, [[view]]");
    }
    return out;
}

std::vector<NamedView> read_view_folder(const std::filesystem::path& folder) {
    std::vector<std::filesystem::path> files;
    std::error_code ignored;
    for (const auto& entry : std::filesystem::directory_iterator(folder, ignored))
        if (entry.path().extension() == ".toml")
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    std::vector<NamedView> out;
    for (const auto& file : files)
        for (NamedView& view : read_views(file))
            out.push_back(std::move(view));
    return out;
}

NamedView find_view(const std::string& look, const std::filesystem::path& folder) {
    if (look.ends_with(".toml") || look.find('/') != std::string::npos) {
        std::vector<NamedView> views = read_views(look);
        if (views.size() != 1)
            throw util::UsageError("place the camera: camera.look = '" + look + "' holds " +
                                   std::to_string(views.size()) +
                                   " views; allowed: a file with one");
        return std::move(views.front());
    }
    std::vector<NamedView> views = read_view_folder(folder);
    const std::string wanted = folded(look);
    NamedView* found = nullptr;
    for (NamedView& view : views) {
        if (!is_called(view, wanted))
            continue;
        if (found != nullptr)
            throw util::UsageError("place the camera: camera.look = '" + look +
                                   "' names two views, '" + found->name + "' in " +
                                   found->file.string() + " and '" + view.name + "' in " +
                                   view.file.string());
        found = &view;
    }
    if (found == nullptr)
        refuse_look(look, views, folder);
    return std::move(*found);
}

SceneLayer file_layer(std::filesystem::path file) {
    return [file = std::move(file)](Scene& scene) {
        if (!file.empty())
            read_scene(file, scene);
    };
}

SceneLayer fields_layer(std::vector<std::pair<std::string, std::string>> fields) {
    return [fields = std::move(fields)](Scene& scene) {
        for (const auto& [path, text] : fields)
            set_field(scene, path, text);
    };
}

namespace {

NamedView choose_view(const std::string& look, const std::filesystem::path& views) {
    return find_view(look, views.empty() ? util::config_dir() / "views" : views);
}

}  // namespace

std::vector<std::string> stated_fields(const std::filesystem::path& file, const std::string& look,
                                       const std::filesystem::path& views) {
    std::vector<std::string> out;
    if (!file.empty())
        out = scene_paths(util::read_toml(file, [&](const std::string& what) {
            throw util::UsageError("read the scene " + file.string() + ": " + what);
        }));
    if (look.empty())
        return out;
    const std::vector<std::string> seen = scene_paths(choose_view(look, views).fields);
    out.insert(out.end(), seen.begin(), seen.end());
    return out;
}

Scene compose_scene(const std::vector<SceneLayer>& layers, const std::filesystem::path& views) {
    const auto over = [&](Scene scene) {
        for (const SceneLayer& layer : layers)
            layer(scene);
        return scene;
    };
    // Any layer may name the view: composing once without a view finds it.
    Scene scene = over({});
    if (scene.camera.look.empty())
        return scene;
    const NamedView view = choose_view(scene.camera.look, views);
    Scene seen;
    read_scene_table(view.fields, "read the view '" + view.name + "'", seen);
    return over(std::move(seen));
}

}  // namespace terravox::scene
