#include "raytracer/core/scene/scene_io.hpp"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <sstream>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/numbers.hpp"
#include "common/util/text.hpp"
#include "common/util/toml_file.hpp"
#include "raytracer/core/scene/scene_fields.hpp"
#include "raytracer/core/scene/views.hpp"

namespace terravox::scene {
namespace {

using util::number_text;

using Triple = std::array<double, 3>;
using Size = std::array<int, 2>;

/// Writes all digits of a whole number if they are few: 100000, not 1e+05.
std::string plain(double v) {
    return v == std::floor(v) && std::abs(v) < 1e15 ? std::to_string(static_cast<std::int64_t>(v))
                                                    : number_text(v);
}

std::vector<std::string> words(const FieldRule& rule) {
    std::vector<std::string> out;
    for (const auto w : rule.words)
        if (!w.empty())
            out.emplace_back(w);
    return out;
}

std::string allowed(const FieldRule& rule) {
    if (!rule.words.empty())
        return util::comma_list(words(rule));
    return number_text(rule.min) + " to " + number_text(rule.max);
}

/// Stores a checked value in a field. `where` begins every message: attempt and object.
class Setter {
public:
    Setter(std::string where, const FieldRule& rule) : m_where(std::move(where)), m_rule(rule) {}

    void put(double value, double& field) const { field = checked(value); }
    void put(double value, std::optional<double>& field) const { field = checked(value); }
    void put(double value, int& field) const {
        if (value != std::floor(value))
            fail(number_text(value), "whole numbers from " + allowed(m_rule));
        field = static_cast<int>(checked(value));
    }
    void put(double value, std::optional<int>& field) const {
        int whole = 0;
        put(value, whole);
        field = whole;
    }
    void put(bool value, bool& field) const { field = value; }
    void put(const std::string& value, std::string& field) const {
        if (!m_rule.words.empty() &&
            std::find(m_rule.words.begin(), m_rule.words.end(), value) == m_rule.words.end())
            fail_as_word(value);
        field = value;
    }
    template <core::WordEnum Enum>
    void put(const std::string& value, Enum& field) const {
        const std::optional<Enum> known = core::from_word<Enum>(value);
        if (!known)
            fail_as_word(value);
        field = *known;
    }
    void put(const std::vector<double>& value, std::optional<Triple>& field) const {
        if (value.size() != 3)
            fail(std::to_string(value.size()) + " numbers", "three finite numbers");
        if (!std::all_of(value.begin(), value.end(), [](double v) { return std::isfinite(v); }))
            fail("(" + number_text(value[0]) + ", " + number_text(value[1]) + ", " +
                     number_text(value[2]) + ")",
                 "three finite numbers");
        for (const double v : value)
            (void)checked(v);
        field = Triple{value[0], value[1], value[2]};
    }
    void put(const std::vector<double>& value, Size& field) const {
        if (value.size() != 2)
            fail(std::to_string(value.size()) + " numbers", "WIDTHxHEIGHT");
        for (const double v : value)
            if (v != std::floor(v) || !(v >= m_rule.min && v <= m_rule.max))
                fail(plain(v), "whole numbers from " + allowed(m_rule));
        field = {static_cast<int>(value[0]), static_cast<int>(value[1])};
    }
    void put(const std::string& value, TileSize& field) const {
        const auto size = TileSize::parse(value);
        if (!size)
            fail("'" + value + "'", TileSize::kAllowed);
        field = *size;
    }
    void put(const std::string& value, PointList& field) const {
        const auto points = PointList::parse(value);
        if (!points)
            fail("'" + value.substr(0, 80) + "'", PointList::kAllowed);
        field = *points;
    }
    [[noreturn]] void fail(const std::string& value, const std::string& range) const {
        throw util::UsageError(m_where + " = " + value + "; allowed: " + range);
    }

private:
    [[noreturn]] void fail_as_word(const std::string& value) const {
        throw util::UsageError(m_where + " = '" + value + "'" +
                               util::allowed_words(value, words(m_rule)));
    }
    [[nodiscard]] double checked(double value) const {
        if (!(value >= m_rule.min && value <= m_rule.max))
            fail(number_text(value), allowed(m_rule));
        return value;
    }
    std::string m_where;
    const FieldRule& m_rule;
};

double parse_number(const Setter& setter, const std::string& text) {
    const auto value = util::parse_number<double>(text);
    if (!value)
        setter.fail("'" + text + "'", "a number");
    return *value;
}

std::vector<double> parse_numbers(const Setter& setter, const std::string& text) {
    std::vector<double> out;
    if (text.ends_with(','))
        setter.fail("'" + text + "'", "numbers with ',' between them");
    std::istringstream stream(text);
    for (std::string part; std::getline(stream, part, ',');)
        out.push_back(parse_number(setter, part));
    return out;
}

void put_text(const Setter& s, const std::string& text, double& f) {
    s.put(parse_number(s, text), f);
}
void put_text(const Setter& s, const std::string& text, std::optional<double>& f) {
    s.put(parse_number(s, text), f);
}
void put_text(const Setter& s, const std::string& text, int& f) {
    s.put(parse_number(s, text), f);
}
void put_text(const Setter& s, const std::string& text, std::optional<int>& f) {
    s.put(parse_number(s, text), f);
}
void put_text(const Setter& s, const std::string& text, std::string& f) {
    s.put(text, f);
}
void put_text(const Setter& s, const std::string& text, std::optional<Triple>& f) {
    s.put(parse_numbers(s, text), f);
}
void put_text(const Setter& s, const std::string& text, Size& f) {
    std::vector<double> sides;
    std::istringstream stream(text);
    for (std::string part; std::getline(stream, part, 'x');) {
        const auto side = util::parse_number<double>(part);
        if (!side)
            break;
        sides.push_back(*side);
    }
    const bool has_two_parts = std::count(text.begin(), text.end(), 'x') == 1;
    if (sides.size() != 2 || !has_two_parts)
        s.fail("'" + text + "'", "WIDTHxHEIGHT in pixels, such as 1280x720");
    s.put(sides, f);
}
void put_text(const Setter& s, const std::string& text, TileSize& f) {
    s.put(text, f);
}
void put_text(const Setter& s, const std::string& text, PointList& f) {
    s.put(text, f);
}
template <core::WordEnum Enum>
void put_text(const Setter& s, const std::string& text, Enum& f) {
    s.put(text, f);
}
void put_text(const Setter& s, const std::string& text, bool& f) {
    if (text == "true" || text == "yes" || text == "on" || text == "1")
        f = true;
    else if (text == "false" || text == "no" || text == "off" || text == "0")
        f = false;
    else
        s.fail("'" + text + "'", "yes, no");
}

void put_node(const Setter& s, const toml::node& node, bool& f) {
    if (!node.is_boolean())
        s.fail(util::toml_value(node), "true, false");
    f = **node.as_boolean();
}
void put_node(const Setter& s, const toml::node& node, std::string& f) {
    if (!node.is_string())
        s.fail(util::toml_value(node), "text in quotes");
    s.put(**node.as_string(), f);
}
std::vector<double> list_numbers(const Setter& s, const toml::node& node) {
    std::vector<double> out;
    if (const auto* array = node.as_array())
        for (const auto& item : *array) {
            const auto v = item.value<double>();
            if (!v)
                s.fail("a list with other values than numbers", "numbers");
            out.push_back(*v);
        }
    return out;
}
void put_node(const Setter& s, const toml::node& node, std::optional<Triple>& f) {
    s.put(list_numbers(s, node), f);
}
void put_node(const Setter& s, const toml::node& node, Size& f) {
    if (const auto text = node.value<std::string>())
        put_text(s, *text, f);
    else
        s.put(list_numbers(s, node), f);
}
void put_node(const Setter& s, const toml::node& node, TileSize& f) {
    if (!node.is_string() && !node.is_integer())
        s.fail(util::toml_value(node),
               std::string("a whole number, or text: ") + TileSize::kAllowed);
    s.put(node.is_integer() ? std::to_string(**node.as_integer()) : **node.as_string(), f);
}
void put_node(const Setter& s, const toml::node& node, PointList& f) {
    if (!node.is_string())
        s.fail(util::toml_value(node), "text in quotes");
    s.put(**node.as_string(), f);
}
template <core::WordEnum Enum>
void put_node(const Setter& s, const toml::node& node, Enum& f) {
    if (!node.is_string())
        s.fail(util::toml_value(node), "text in quotes");
    s.put(**node.as_string(), f);
}
template <class Number>
void put_node(const Setter& s, const toml::node& node, Number& f) {
    const auto v = node.value<double>();
    if (!v)
        s.fail(util::toml_value(node), "a number");
    s.put(*v, f);
}

void write(std::ostream& out, double v) {
    out << number_text(v)
        << (std::isfinite(v) && number_text(v).find_first_of(".e") == std::string::npos ? ".0"
                                                                                        : "");
}
void write(std::ostream& out, int v) {
    out << v;
}
void write(std::ostream& out, bool v) {
    out << (v ? "true" : "false");
}
void write(std::ostream& out, const std::string& v) {
    out << toml::value<std::string>(v);
}
template <core::WordEnum Enum>
void write(std::ostream& out, Enum v) {
    write(out, std::string(core::to_word(v)));
}
void write(std::ostream& out, const Size& v) {
    out << '"' << v[0] << 'x' << v[1] << '"';
}
void write(std::ostream& out, const TileSize& v) {
    write(out, v.text());
}
void write(std::ostream& out, const PointList& v) {
    write(out, v.text());
}
void write(std::ostream& out, const Triple& v) {
    out << '[';
    for (std::size_t i = 0; i < 3; ++i) {
        out << (i == 0 ? "" : ", ");
        write(out, v[i]);
    }
    out << ']';
}

template <class T>
constexpr bool kOptional = false;
template <class T>
constexpr bool kOptional<std::optional<T>> = true;

std::string flag_text(double v) {
    return plain(v);
}
std::string flag_text(int v) {
    return std::to_string(v);
}
std::string flag_text(bool v) {
    return v ? "yes" : "no";
}
std::string flag_text(const std::string& v) {
    return v;
}
template <core::WordEnum Enum>
std::string flag_text(Enum v) {
    return std::string(core::to_word(v));
}
std::string flag_text(const Size& v) {
    return std::to_string(v[0]) + "x" + std::to_string(v[1]);
}
std::string flag_text(const TileSize& v) {
    return v.text();
}
std::string flag_text(const PointList& v) {
    return v.text();
}
std::string flag_text(const Triple& v) {
    return plain(v[0]) + "," + plain(v[1]) + "," + plain(v[2]);
}

/// The end of a message about an unknown name: one that is near, or else where all are listed.
std::string near_or(std::string_view name, const std::set<std::string>& known,
                    const std::string& list) {
    const std::string near = util::did_you_mean(name, std::vector(known.begin(), known.end()));
    return near.empty() ? list : near;
}

}  // namespace

void read_scene_table(const toml::table& root, const std::string& attempt, Scene& scene) {
    std::set<std::string> known;
    std::set<std::string> sections;
    visit_fields(scene, [&](std::string_view path, auto& field, const FieldRule& rule) {
        known.emplace(path);
        sections.emplace(path.substr(0, path.find('.')));
        const auto node = root.at_path(path);
        if (node)
            put_node(Setter(attempt + ": " + std::string(path), rule), *node.node(), field);
        if (rule.former.empty())
            return;
        known.emplace(rule.former);
        const auto former = root.at_path(rule.former);
        if (!former)
            return;
        if (node)
            throw util::UsageError(attempt + ": " + std::string(path) + " and " +
                                   std::string(rule.former) +
                                   ", which is its former name; allowed: one of them");
        put_node(Setter(attempt + ": " + std::string(rule.former), rule), *former.node(), field);
        util::log_warn("{}: {} is called {} now; a later version will refuse the former name",
                       attempt, rule.former, path);
    });
    for (const auto& [section, node] : root) {
        const auto* table = node.as_table();
        if (table == nullptr)
            throw util::UsageError(attempt + ": unknown field '" + std::string(section.str()) +
                                   "'");
        for (const auto& [key, value] : *table)
            if (const std::string path = std::string(section.str()) + "." + std::string(key.str());
                !known.contains(path))
                throw util::UsageError(
                    attempt + ": unknown field '" + path + "'" +
                    near_or(path, known, "; docs/formats/scene.md lists all fields"));
        if (!sections.contains(std::string(section.str())))
            throw util::UsageError(
                attempt + ": unknown section '" + std::string(section.str()) + "'" +
                near_or(section.str(), sections, "; docs/formats/scene.md lists all sections"));
    }
}

std::vector<std::string> scene_paths(const toml::table& sections) {
    std::vector<std::string> out;
    for (const auto& [section, node] : sections)
        if (const auto* table = node.as_table())
            for (const auto& [key, value] : *table)
                out.push_back(std::string(section.str()) + "." + std::string(key.str()));
    std::sort(out.begin(), out.end());
    return out;
}

namespace {

std::function<void(const std::string&)> refusing(const std::string& attempt) {
    return [attempt](const std::string& what) { throw util::UsageError(attempt + ": " + what); };
}

void read_scene_root(toml::table root, const std::string& attempt, Scene& scene) {
    if (const toml::node* version = root.get("version");
        version != nullptr && version->value<int>() != kSceneVersion)
        throw util::UsageError(attempt + ": version = " + util::toml_value(*version) +
                               "; allowed: " + std::to_string(kSceneVersion));
    root.erase("version");
    read_scene_table(root, attempt, scene);
}

}  // namespace

void read_scene(const std::filesystem::path& file, Scene& scene) {
    const std::string attempt = "read the scene " + file.string();
    read_scene_root(util::read_toml(file, refusing(attempt)), attempt, scene);
}

void parse_scene(const std::string& text, const std::string& name, Scene& scene) {
    const std::string attempt = "read the scene " + name;
    read_scene_root(util::parse_toml(text, name, refusing(attempt)), attempt, scene);
}

namespace {

/// @param where begins every message
void set_field_at(Scene& scene, const std::string& path, const std::string& text,
                  const std::string& where) {
    bool found = false;
    visit_fields(scene, [&](std::string_view name, auto& field, const FieldRule& rule) {
        if (name != path)
            return;
        found = true;
        put_text(Setter(where, rule), text, field);
    });
    if (!found)
        throw util::UsageError(where + ": no such field of a scene");
}

}  // namespace

void set_field(Scene& scene, const std::string& path, const std::string& text) {
    set_field_at(scene, path, text, "set " + path);
}

std::string find_fault(const std::string& path, const std::string& text, const std::string& flag) {
    try {
        Scene scene;
        set_field_at(scene, path, text, flag);
        return {};
    } catch (const util::UsageError& e) {
        return e.what();
    }
}

std::string to_toml(const Scene& scene) {
    std::ostringstream out;
    out << "version = " << kSceneVersion << "\n";
    std::string section;
    visit_fields(scene, [&](std::string_view path, const auto& field, const FieldRule& rule) {
        using Field = std::decay_t<decltype(field)>;
        if constexpr (kOptional<Field>) {
            if (!field)
                return;
        }
        const auto dot_at = path.find('.');
        if (path.substr(0, dot_at) != section) {
            section = path.substr(0, dot_at);
            out << "\n[" << section << "]\n";
        }
        out << path.substr(dot_at + 1) << " = ";
        if constexpr (kOptional<Field>)
            write(out, *field);
        else
            write(out, field);
        out << "  # " << rule.doc << "\n";
    });
    return out.str();
}

std::vector<FieldText> field_texts(const Scene& scene) {
    std::vector<FieldText> out;
    visit_fields(scene, [&](std::string_view path, const auto& field, const FieldRule&) {
        FieldText& to = out.emplace_back(FieldText{std::string(path), {}});
        if constexpr (kOptional<std::decay_t<decltype(field)>>) {
            if (field)
                to.text = flag_text(*field);
        } else
            to.text = flag_text(field);
    });
    return out;
}

std::vector<FieldText> changed_fields(const Scene& scene, const Scene& from) {
    std::vector<FieldText> out = field_texts(scene);
    const std::vector<FieldText> before = field_texts(from);
    std::size_t i = 0;
    std::erase_if(out, [&](const FieldText& f) { return f == before[i++]; });
    return out;
}

std::string find_flag(std::string_view path) {
    std::string out = "--" + std::string(path);
    std::replace_if(out.begin() + 2, out.end(), [](char c) { return c == '.' || c == '_'; }, '-');
    return out;
}

Scene what_shows(Scene scene) {
    const Scene plain;
    scene.processing = plain.processing;
    scene.world.memory_mib = plain.world.memory_mib;
    scene.quality.tile = plain.quality.tile;
    scene.quality.tile_order = plain.quality.tile_order;
    scene.quality.coarse_step = plain.quality.coarse_step;
    return scene;
}

std::vector<SceneFlag> scene_flags() {
    std::vector<SceneFlag> out;
    Scene scene;
    visit_fields(scene, [&](std::string_view path, auto& field, const FieldRule& rule) {
        std::string names = find_flag(path);
        if (!rule.alias.empty())
            names += "," + std::string(rule.alias);
        std::string help(rule.doc);
        if (!rule.words.empty())
            help += " (" + allowed(rule) + ")";
        else if (std::isfinite(rule.min) && std::isfinite(rule.max) && rule.max > rule.min)
            help += " (" + allowed(rule) + ")";
        std::ostringstream preset;
        using Field = std::decay_t<decltype(field)>;
        if constexpr (!kOptional<Field>)
            write(preset, field);
        if (!preset.str().empty() && preset.str() != "''" && preset.str() != "\"\"")
            help += ", default " + preset.str();
        out.push_back({names, std::string(path), help,
                       rule.former.empty() ? std::string{} : find_flag(rule.former),
                       std::is_same_v<Field, bool>});
    });
    return out;
}

}  // namespace terravox::scene
