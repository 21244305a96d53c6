#include "voxelserver/make/voxelize/points/settings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <cstddef>
#include <functional>
#include <string>
#include <variant>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"
#include "common/util/toml_file.hpp"
#include "common/voxel/fingerprint.hpp"

namespace terravox::voxelize {
namespace {

/// The place of a field in a file, and its allowed values.
struct Field {
    std::string section;
    std::string name;
    std::variant<bool*, double*, std::string*> value;
    double low = 0;  ///< of numbers
    double high = 0;
    std::string old_name = {};  ///< still accepted for one more version, with a warning
};

/// The steps that had another key before.
std::string to_old_key(const StepSwitch& step) {
    return step.on == &Settings::Steps::vegetation ? "vegetation_fill" : "";
}

std::vector<Field> list_fields(Settings& s) {
    std::vector<Field> out = {
        {"points", "drop_withheld", &s.points.drop_withheld},
        {"points", "drop_overlap", &s.points.drop_overlap},
        {"points", "drop_isolated", &s.points.drop_isolated},
    };
    for (const StepSwitch& step : kStepSwitches)
        out.push_back({"steps", to_key(step), &(s.steps.*step.on), 0, 0, to_old_key(step)});
    const std::vector<Field> others = {
        {"buildings", "storey_m", &s.buildings.storey_m, 1, 20},
        {"buildings", "steep_roof_m", &s.buildings.steep_roof_m, 0, 50},
        {"bridges", "thickness_m", &s.bridges.thickness_m, 0.1, 20},
        {"bridges", "recognise", &s.bridges.recognise},
        {"bridges", "widest_m", &s.bridges.widest_m, 1, 15},
        {"bridges", "min_drop_m", &s.bridges.min_drop_m, 0.5, 20, "least_drop_m"},
        {"bridges", "above_water_m", &s.bridges.above_water_m, 0.5, 50},
        {"bridges", "above_land_m", &s.bridges.above_land_m, 0.5, 50},
        {"ground", "soil_m", &s.ground.soil_m, 0, 100},
        {"ground", "cliff_m", &s.ground.cliff_m, 0, 1000},
        {"ground", "depth_m", &s.ground.depth_m, 0, 10'000},
        {"vegetation", "low_m", &s.vegetation.low_m, 0, 50},
        {"vegetation", "medium_m", &s.vegetation.medium_m, 0, 50},
        {"vegetation", "canopy_gap_m", &s.vegetation.canopy_gap_m, 0, 50},
        {"vegetation", "trunk_from_m", &s.vegetation.trunk_from_m, 0, 100},
        {"vegetation", "clutter_m", &s.vegetation.clutter_m, 0, 10},
        {"water", "from_class", &s.water.from_class},
        {"water", "from_orthophoto", &s.water.from_orthophoto},
        {"water", "from_voids", &s.water.from_voids},
        {"water", "slope", &s.water.slope, 0, 10},
        {"water", "min_depth_m", &s.water.min_depth_m, 0, 100},
        {"water", "max_depth_m", &s.water.max_depth_m, 0, 100},
        {"orthophoto", "albedo", &s.orthophoto.albedo},
        {"material_guesses", "asphalt_below", &s.material_guesses.asphalt_below, 0, 2.5},
        {"material_guesses", "bare_below", &s.material_guesses.bare_below, 0, 2.5},
        {"material_guesses", "flat_slope", &s.material_guesses.flat_slope, 0, 10},
        {"material_guesses", "flat_share", &s.material_guesses.flat_share, 0, 2},
        {"material_guesses", "tiles_from", &s.material_guesses.tiles_from, 0, 2.5},
        {"specialization", "palette", &s.palette},
        {"colour_variation", "tints", &s.tints},
    };
    out.insert(out.end(), others.begin(), others.end());
    return out;
}

using Fail = std::function<void(const std::string&)>;

std::vector<std::string> list_sections(const std::vector<Field>& fields) {
    std::vector<std::string> out;
    for (const Field& f : fields)
        if (out.empty() || out.back() != f.section)
            out.push_back(f.section);
    return out;
}

/// @param key of an entry of the section; an old name is replaced by the field's own, with a
/// warning
const Field& find_field(const std::vector<Field>& fields, const std::string& section,
                        const std::string& key, const toml::table& table, const Fail& fail) {
    std::string allowed;
    for (const Field& f : fields) {
        if (f.section != section)
            continue;
        if (f.name == key)
            return f;
        if (!f.old_name.empty() && f.old_name == key) {
            if (table.contains(f.name))
                fail(section + "." + key + " is the old name of " + section + "." + f.name +
                     ", which is given, too; allowed: one of them");
            util::log_warn("voxelization settings: {0}.{1} is now {0}.{2}; the old name will go",
                           section, key, f.name);
            return f;
        }
        allowed += (allowed.empty() ? "" : ", ") + f.name;
    }
    fail(section + "." + key + " is unknown; allowed in [" + section + "]: " + allowed);
    throw util::Error("read the voxelization settings: an unknown field was not refused");
}

void read_value(const Field& field, const std::string& path, const toml::node& value,
                const Fail& fail) {
    if (bool* const* flag = std::get_if<bool*>(&field.value)) {
        if (!value.is_boolean())
            fail(path + " is not true or false");
        **flag = value.value_or(false);
    } else if (double* const* number = std::get_if<double*>(&field.value)) {
        const auto v = value.value<double>();
        if (!v || !(*v >= field.low && *v <= field.high))
            fail(path + (v ? fmt::format(" = {}", *v) : " is no number") +
                 fmt::format("; allowed: {} to {}", field.low, field.high));
        **number = *v;
    } else {
        if (!value.is_string())
            fail(path + " is no text");
        *std::get<std::string*>(field.value) = value.value_or(std::string());
    }
}

void read_root(const toml::table& root, const std::vector<Field>& fields, const Fail& fail) {
    const std::vector<std::string> sections = list_sections(fields);
    for (const auto& [key, node] : root) {
        const std::string section(key.str());
        const auto* table = node.as_table();
        if (table == nullptr ||
            std::find(sections.begin(), sections.end(), section) == sections.end())
            fail(section + fmt::format(" is no section; allowed: {}", fmt::join(sections, ", ")));
        for (const auto& [name, value] : *table) {
            const std::string text(name.str());
            const Field& field = find_field(fields, section, text, *table, fail);
            read_value(field, section + "." + text, value, fail);
        }
    }
}

}  // namespace

voxel::Fingerprint to_fingerprint(const Settings& settings) {
    Settings copy = settings;  // list_fields() needs a mutable object
    voxel::ByteWriter out;
    for (const Field& f : list_fields(copy)) {
        if (std::holds_alternative<std::string*>(f.value))
            continue;
        out.add(f.section);
        out.add(f.name);
        if (bool* const* flag = std::get_if<bool*>(&f.value))
            out.add(**flag);
        else
            out.add(*std::get<double*>(f.value));
    }
    return out.fingerprint();
}

Settings load_settings(const std::filesystem::path& given, std::string_view steps,
                       std::string_view photo) {
    const std::filesystem::path file = given.empty() ? util::config_dir() / "voxelize.toml" : given;
    const auto fail = [&](const std::string& what) {
        throw util::UsageError("read the voxelization settings {}: {}", file.string(), what);
    };
    Settings out;
    read_root(util::read_toml(file, fail), list_fields(out), fail);
    if (out.water.min_depth_m > out.water.max_depth_m)
        fail(fmt::format("water.min_depth_m = {} is above water.max_depth_m = {}",
                         out.water.min_depth_m, out.water.max_depth_m));
    switch_steps(steps, out.steps);
    if (!photo.empty() && photo != "albedo" && photo != "raw")
        throw util::UsageError("read the option --photo: '{}'; allowed: albedo, raw", photo);
    if (!photo.empty())
        out.orthophoto.albedo = photo == "albedo";
    return out;
}

namespace {

constexpr std::string_view kAll = "all";
constexpr std::string_view kNone = "none";

/// @return nullptr when no step has this key
const StepSwitch* find_switch(std::string_view key) {
    const auto found = std::find_if(kStepSwitches.begin(), kStepSwitches.end(),
                                    [&](const StepSwitch& s) { return to_key(s) == key; });
    return found == kStepSwitches.end() ? nullptr : &*found;
}

void switch_all(bool on, Settings::Steps& steps) {
    for (const StepSwitch& step : kStepSwitches)
        steps.*step.on = on;
}

[[noreturn]] void refuse(std::string_view word) {
    std::vector<std::string> allowed{std::string(kAll), std::string(kNone)};
    for (const StepSwitch& step : kStepSwitches)
        allowed.push_back(to_key(step));
    throw util::UsageError(
        "choose the steps of voxelization: '{}' is no step{}, each step also with - before it to "
        "leave it out",
        word, util::allowed_words(word, allowed));
}

/// Applies one word to the switches.
/// @return whether the word is allowed
bool switch_word(std::string_view word, bool first, Settings::Steps& steps) {
    if (word == kAll || word == kNone) {
        switch_all(word == kAll, steps);
        return true;
    }
    const bool on = !word.starts_with('-');
    const StepSwitch* step = find_switch(on ? word : word.substr(1));
    if (step == nullptr)
        return false;
    if (on && first)
        switch_all(false, steps);
    steps.*step->on = on;
    return true;
}

}  // namespace

std::string to_key(const StepSwitch& step) {
    std::string out(step.name);
    std::replace(out.begin(), out.end(), ' ', '_');
    return out;
}

void switch_steps(std::string_view text, Settings::Steps& steps) {
    if (text.empty())
        return;
    std::size_t begin = 0;
    while (begin <= text.size()) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        const std::string_view word = text.substr(begin, end - begin);
        if (!switch_word(word, begin == 0, steps))
            refuse(word);
        begin = end + 1;
    }
}

std::string steps_help() {
    constexpr std::size_t kWidth = 24;
    std::string out = "Steps of voxelization (--steps):";
    for (const StepSwitch& step : kStepSwitches) {
        const std::string key = to_key(step);
        out += "\n  " + key + std::string(kWidth - std::min(kWidth - 1, key.size()), ' ') +
               std::string(step.doc);
    }
    return out;
}

}  // namespace terravox::voxelize
