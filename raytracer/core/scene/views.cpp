#include "raytracer/core/scene/views.hpp"

#include <algorithm>

#include "common/util/config_dir.hpp"
#include "common/util/error.hpp"
#include "common/util/near_words.hpp"
#include "common/util/toml_file.hpp"
#include "raytracer/core/scene/names.hpp"
#include "raytracer/core/scene/scene_io.hpp"
#include "raytracer/core/scene/scene_table.hpp"

namespace terravox::scene {
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
    const NamedView view =
        find_view(scene.camera.look, views.empty() ? util::config_dir() / "views" : views);
    Scene seen;
    read_scene_table(view.fields, "read the view '" + view.name + "'", seen);
    return over(std::move(seen));
}

}  // namespace terravox::scene
