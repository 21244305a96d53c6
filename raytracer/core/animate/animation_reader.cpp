#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <set>
#include <type_traits>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/toml_file.hpp"
#include "raytracer/core/animate/animation.hpp"
#include "raytracer/core/scene/scene_fields.hpp"
#include "raytracer/core/scene/views.hpp"

namespace terravox::animate {

/// Reads the file of an animation, part by part.
class AnimationReader {
public:
    /// @param read_root returns the file's table; its argument throws an error with the given
    /// message
    template <class ReadRoot>
    AnimationReader(const std::string& name, const std::filesystem::path& views,
                    const ReadRoot& read_root)
        : m_views(views) {
        m_out.m_attempt = "read the animation " + name;
        m_root = read_root([this](const std::string& what) { refuse(what); });
    }

    [[nodiscard]] Animation read() {
        if (const auto* version = m_root.get("version");
            version != nullptr && version->value_exact<std::int64_t>() != 1)
            refuse("version = " + util::toml_value(*version) + "; allowed: 1");
        m_out.m_fps = number(m_root, "fps", "fps", 0.01, 1000).value_or(25);
        const auto seconds = number(m_root, "seconds", "seconds", 0, kMaxSeconds);
        m_at_rest = yes_or_no("ease");
        read_keys();
        read_turntable();
        read_day();
        if (m_keys.empty() && !m_out.m_turntable && !m_out.m_day)
            refuse("nothing moves; give [[key]], [turntable] or [day]");
        set_length(seconds);
        make_tracks();
        m_out.m_base = m_root;
        for (const char* own : {"version", "fps", "seconds", "ease", "key", "turntable", "day"})
            m_out.m_base.erase(own);
        scene::Scene checked;
        m_out.apply_base(checked);
        return std::move(m_out);
    }

private:
    static constexpr double kMaxSeconds = 1e7;
    struct Key {
        double time_s = 0;
        std::string name;  ///< "key 3", for messages
        std::set<std::string> paths;
        scene::Scene scene;
    };

    [[noreturn]] void refuse(const std::string& what) const {
        throw util::UsageError(m_out.m_attempt + ": " + what);
    }
    static std::string to_text(double v) {
        std::string out = std::to_string(v);
        out.erase(out.find_last_not_of('0') + 1);
        if (out.ends_with('.'))
            out.pop_back();
        return out;
    }

    std::optional<double> number(const toml::table& table, const char* key, const std::string& name,
                                 double min, double max) const {
        const auto* node = table.get(key);
        if (node == nullptr)
            return std::nullopt;
        const auto value = node->is_number() ? node->value<double>() : std::nullopt;
        if (!value)
            refuse(name + " = " + util::toml_value(*node) + "; allowed: a number");
        if (!(*value >= min && *value <= max))
            refuse(name + " = " + to_text(*value) + "; allowed: " + to_text(min) + " to " +
                   to_text(max));
        return value;
    }
    bool yes_or_no(const char* key) const {
        const auto* node = m_root.get(key);
        if (node == nullptr)
            return false;
        if (!node->is_boolean())
            refuse(std::string(key) + " = " + util::toml_value(*node) + "; allowed: true, false");
        return **node->as_boolean();
    }
    const toml::table* section(const char* name,
                               std::initializer_list<std::string_view> known) const {
        const auto* node = m_root.get(name);
        if (node == nullptr)
            return nullptr;
        const auto* table = node->as_table();
        if (table == nullptr)
            refuse(std::string(name) + " = " + util::toml_value(*node) + "; allowed: [" + name +
                   "]");
        for (const auto& [key, value] : *table)
            if (std::find(known.begin(), known.end(), key.str()) == known.end())
                refuse("unknown field '" + std::string(name) + "." + std::string(key.str()) + "'");
        return table;
    }

    void read_keys() {
        const auto* node = m_root.get("key");
        if (node == nullptr)
            return;
        const auto* keys = node->as_array();
        if (keys == nullptr)
            refuse("key = " + util::toml_value(*node) + "; allowed: [[key]]");
        for (const auto& item : *keys) {
            const std::string name = "key " + std::to_string(m_keys.size() + 1);
            const auto* table = item.as_table();
            if (table == nullptr)
                refuse(name + " = " + util::toml_value(item) + "; allowed: [[key]]");
            Key key = read_key(*table, name);
            if (!m_keys.empty() && !(key.time_s > m_keys.back().time_s))
                refuse(name + ": its time, " + to_text(key.time_s) +
                       " s, is not after that of the key before, " + to_text(m_keys.back().time_s) +
                       " s");
            m_keys.push_back(std::move(key));
        }
    }

    Key read_key(const toml::table& table, const std::string& name) const {
        Key out;
        out.name = name;
        const auto time = number(table, "time_s", name + ": time_s", 0, kMaxSeconds);
        const auto frame = number(table, "frame", name + ": frame", 0, Animation::kMaxFrames - 1);
        if (time.has_value() == frame.has_value())
            refuse(name + ": " + (time ? "time_s and frame" : "no time") +
                   "; allowed: one of time_s, frame");
        if (frame && *frame != std::floor(*frame))
            refuse(name + ": frame = " + to_text(*frame) + "; allowed: whole numbers");
        out.time_s = time ? *time : *frame / m_out.m_fps;
        toml::table fields = table;
        fields.erase("time_s");
        fields.erase("frame");
        const std::string attempt = m_out.m_attempt + ": " + name;
        scene::Scene own;
        scene::read_scene_table(fields, attempt, own);
        if (!own.camera.look.empty()) {
            const scene::NamedView view = scene::find_view(
                own.camera.look, m_views.empty() ? util::config_dir() / "views" : m_views);
            scene::read_scene_table(view.fields, attempt, out.scene);
            for (const auto& path : scene::scene_paths(view.fields))
                out.paths.insert(path);
        }
        scene::read_scene_table(fields, attempt, out.scene);
        for (const auto& path : scene::scene_paths(fields))
            out.paths.insert(path);
        out.paths.erase("camera.look");
        for (const auto& path : out.paths)
            if (path == "output.size" || path == "quality.tile" || path.starts_with("world.") ||
                path.starts_with("processing."))
                refuse(name + ": " + path +
                       " stays the same in all frames; give it outside of keys");
        return out;
    }

    void read_turntable() {
        const auto* table = section("turntable", {"turns", "seconds", "target"});
        if (table == nullptr)
            return;
        Animation::Turntable out;
        out.turns = number(*table, "turns", "turntable.turns", -10000, 10000).value_or(1);
        out.seconds =
            number(*table, "seconds", "turntable.seconds", 0.001, kMaxSeconds).value_or(0);
        if (const auto* target = table->get("target")) {
            // Read in the same way as a field of a scene.
            toml::table fields{{"camera", toml::table{}}};
            fields["camera"].as_table()->insert("target", *target);
            scene::Scene scene;
            scene::read_scene_table(fields, m_out.m_attempt + ": turntable", scene);
            out.target = scene.camera.target;
        }
        m_out.m_turntable = out;
    }

    void read_day() {
        const auto* table = section("day", {"from", "to", "seconds"});
        if (table == nullptr)
            return;
        const auto from = number(*table, "from", "day.from", 0, 24);
        const auto to = number(*table, "to", "day.to", 0, 24);
        if (!from || !to)
            refuse(std::string("day.") + (from ? "to" : "from") +
                   " is missing; allowed: 0 to 24, clock hours");
        m_out.m_day = Animation::Day{
            *from, *to, number(*table, "seconds", "day.seconds", 0.001, kMaxSeconds).value_or(0)};
        for (const Key& key : m_keys)
            if (key.paths.contains("sun.time_h"))
                refuse(key.name + ": sun.time_h, and [day]; give one of them");
    }

    void set_length(const std::optional<double>& seconds) {
        auto& turntable = m_out.m_turntable;
        auto& day = m_out.m_day;
        double length = m_keys.empty() ? 0 : m_keys.back().time_s;
        if (turntable)
            length = std::max(length, turntable->seconds);
        if (day)
            length = std::max(length, day->seconds);
        if (seconds) {
            if (*seconds < length)
                refuse("seconds = " + to_text(*seconds) + "; allowed: " + to_text(length) +
                       " and more, the time of the last key, [turntable] or [day]");
            length = *seconds;
        }
        if ((turntable || day) && !(length > 0))
            refuse(std::string(turntable ? "[turntable]" : "[day]") +
                   " has no length; give seconds");
        if (turntable && turntable->seconds == 0)
            turntable->seconds = length;
        if (day && day->seconds == 0)
            day->seconds = length;
        const double count = length * m_out.m_fps;
        if (!(count < Animation::kMaxFrames))
            refuse(to_text(length) + " s at " + to_text(m_out.m_fps) +
                   " frames a second; allowed: up to " + std::to_string(Animation::kMaxFrames) +
                   " frames");
        // After whole turns the last picture would repeat the first: the frames then form a loop.
        const bool loop = turntable && m_keys.empty() && !day && turntable->seconds == length &&
                          turntable->turns == std::floor(turntable->turns);
        m_out.m_frames = loop ? std::max(static_cast<int>(std::floor(count + 0.5)), 1)
                              : static_cast<int>(std::floor(count + 1e-6)) + 1;
    }

    void make_tracks() {
        std::set<std::string> paths;
        for (const Key& key : m_keys)
            paths.insert(key.paths.begin(), key.paths.end());
        for (const auto& path : paths)
            m_out.m_tracks.emplace(path, make_track(path));
        if (const auto space = m_out.m_tracks.find("camera.space"); space != m_out.m_tracks.end())
            for (const auto& word : space->second.words)
                if (word != space->second.words.front())
                    refuse("camera.space changes between keys; allowed: the same in all");
    }

    [[nodiscard]] Animation::Track make_track(const std::string& path) const {
        Animation::Track out;
        std::vector<std::vector<double>> numbers;
        for (const Key& key : m_keys) {
            if (!key.paths.contains(path))
                continue;
            out.times.push_back(key.time_s);
            scene::visit_fields(
                key.scene, [&](std::string_view name, const auto& field, const scene::FieldRule&) {
                    if (name != path)
                        return;
                    using Field = std::decay_t<decltype(field)>;
                    if constexpr (std::is_same_v<Field, double>)
                        add_numbers(numbers, {field});
                    else if constexpr (std::is_same_v<Field, std::optional<double>>)
                        add_numbers(numbers, {*field});
                    else if constexpr (std::is_same_v<Field, std::optional<std::array<double, 3>>>)
                        add_numbers(numbers, {(*field)[0], (*field)[1], (*field)[2]});
                    else if constexpr (std::is_same_v<Field, int> || std::is_same_v<Field, bool> ||
                                       std::is_same_v<Field, std::string>)
                        out.words.emplace_back(field);
                    else if constexpr (core::WordEnum<Field>)
                        out.words.emplace_back(std::string(core::to_word(field)));
                });
        }
        const bool place = path == "camera.position" || path == "camera.target";
        for (auto& values : numbers)
            out.paths.emplace_back(out.times, std::move(values),
                                   place ? SmoothPath::Kind::kRound : SmoothPath::Kind::kMonotone,
                                   m_at_rest);
        return out;
    }
    static void add_numbers(std::vector<std::vector<double>>& to,
                            std::initializer_list<double> values) {
        to.resize(values.size());
        std::size_t i = 0;
        for (const double v : values)
            to[i++].push_back(v);
    }

    std::filesystem::path m_views;
    Animation m_out;
    toml::table m_root;
    bool m_at_rest = false;
    std::vector<Key> m_keys;
};

Animation Animation::read(const std::filesystem::path& file, const std::filesystem::path& views) {
    return AnimationReader(file.string(), views,
                           [&](const auto& fail) { return util::read_toml(file, fail); })
        .read();
}

Animation Animation::parse(const std::string& text, const std::string& name,
                           const std::filesystem::path& views) {
    return AnimationReader(name, views,
                           [&](const auto& fail) { return util::parse_toml(text, name, fail); })
        .read();
}

}  // namespace terravox::animate
