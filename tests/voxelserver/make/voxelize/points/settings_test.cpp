// The settings file: what ships equals the defaults, and every error in one is named.
// Steps chosen by name.
#include <toml++/toml.h>
#include <filesystem>
#include <fstream>
#include <map>

#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;
using voxelize::Settings;

namespace {

/// Every field by its name in the file, as text.
std::map<std::string, std::string> list_fields(const Settings& s) {
    std::map<std::string, std::string> out;
    const auto flag = [&](const char* name, bool v) { out[name] = v ? "true" : "false"; };
    const auto number = [&](const char* name, double v) { out[name] = std::to_string(v); };
    flag("points.drop_withheld", s.points.drop_withheld);
    flag("points.drop_overlap", s.points.drop_overlap);
    flag("points.drop_isolated", s.points.drop_isolated);
    flag("steps.building_fill", s.steps.building_fill);
    flag("steps.bridges", s.steps.bridges);
    flag("steps.ground_fill", s.steps.ground_fill);
    flag("steps.vegetation", s.steps.vegetation);
    flag("steps.colour_variation", s.steps.colour_variation);
    flag("steps.specialization", s.steps.specialization);
    flag("steps.neighbourhood_filters", s.steps.neighbourhood_filters);
    flag("steps.material_guesses", s.steps.material_guesses);
    flag("steps.water_equalization", s.steps.water_equalization);
    flag("steps.water_deepening", s.steps.water_deepening);
    number("buildings.storey_m", s.buildings.storey_m);
    number("buildings.steep_roof_m", s.buildings.steep_roof_m);
    number("bridges.thickness_m", s.bridges.thickness_m);
    flag("bridges.recognise", s.bridges.recognise);
    number("bridges.widest_m", s.bridges.widest_m);
    number("bridges.min_drop_m", s.bridges.min_drop_m);
    number("bridges.above_water_m", s.bridges.above_water_m);
    number("bridges.above_land_m", s.bridges.above_land_m);
    number("ground.soil_m", s.ground.soil_m);
    number("ground.cliff_m", s.ground.cliff_m);
    number("ground.depth_m", s.ground.depth_m);
    number("vegetation.low_m", s.vegetation.low_m);
    number("vegetation.medium_m", s.vegetation.medium_m);
    number("vegetation.canopy_gap_m", s.vegetation.canopy_gap_m);
    number("vegetation.trunk_from_m", s.vegetation.trunk_from_m);
    number("vegetation.clutter_m", s.vegetation.clutter_m);
    flag("water.from_class", s.water.from_class);
    flag("water.from_orthophoto", s.water.from_orthophoto);
    flag("water.from_voids", s.water.from_voids);
    number("water.slope", s.water.slope);
    number("water.min_depth_m", s.water.min_depth_m);
    number("water.max_depth_m", s.water.max_depth_m);
    flag("orthophoto.albedo", s.orthophoto.albedo);
    number("material_guesses.asphalt_below", s.material_guesses.asphalt_below);
    number("material_guesses.bare_below", s.material_guesses.bare_below);
    number("material_guesses.flat_slope", s.material_guesses.flat_slope);
    number("material_guesses.flat_share", s.material_guesses.flat_share);
    number("material_guesses.tiles_from", s.material_guesses.tiles_from);
    out["specialization.palette"] = s.palette;
    out["colour_variation.tints"] = s.tints;
    return out;
}

/// Every leaf of a file, read without the reader under test.
std::map<std::string, std::string> list_leaves(const std::filesystem::path& file) {
    std::map<std::string, std::string> out;
    for (const auto& [section, node] : toml::parse_file(file.string()))
        for (const auto& [name, value] : *node.as_table()) {
            std::string& text = out[std::string(section.str()) + "." + std::string(name.str())];
            if (value.is_boolean())
                text = value.value_or(false) ? "true" : "false";
            else if (value.is_string())
                text = value.value_or(std::string());
            else
                text = std::to_string(value.value_or(-1.0));
        }
    return out;
}

/// A file with some settings in it.
class File {
public:
    explicit File(const std::string& text) { std::ofstream(path()) << text; }
    [[nodiscard]] std::filesystem::path path() const { return m_folder.path() / "settings.toml"; }

private:
    TemporaryFolder m_folder;
};

/// The keys of the steps that are on, in order, with commas.
std::string on(const Settings::Steps& steps) {
    std::string out;
    for (const StepSwitch& step : kStepSwitches)
        if (steps.*step.on)
            out += (out.empty() ? "" : ",") + to_key(step);
    return out;
}

const std::string kAllOn =
    "water_equalization,water_deepening,bridges,ground_fill,building_fill,vegetation,"
    "colour_variation,specialization,neighbourhood_filters,material_guesses";

}  // namespace

TEST_CASE("the settings that ship are the defaults, every one of them",
          "[voxelserver][voxelize][settings]") {
    const auto file = util::config_dir() / "voxelize.toml";
    const auto defaults = list_fields(Settings{});
    CHECK(list_leaves(file) == defaults);
    CHECK(list_fields(voxelize::load_settings(file)) == defaults);
    CHECK(list_fields(voxelize::load_settings({})) == defaults);
}

TEST_CASE("what a settings file leaves out keeps its value, what it says counts",
          "[voxelserver][voxelize][settings]") {
    CHECK(list_fields(voxelize::load_settings(File("").path())) == list_fields(Settings{}));
    CHECK(voxelize::load_settings(File("[ground]\ndepth_m = 20\n").path()).ground.depth_m == 20);
    // Each field of the shipped file on its own, changed.
    for (const auto& [name, value] : list_fields(Settings{})) {
        const auto dot = name.find('.');
        const bool flag = value == "true" || value == "false";
        const bool text = name == "specialization.palette" || name == "colour_variation.tints";
        const std::string other = flag   ? (value == "true" ? "false" : "true")
                                  : text ? "\"red\""
                                         : "1.25";
        const File file("[" + name.substr(0, dot) + "]\n" + name.substr(dot + 1) + " = " + other +
                        "\n");
        auto wanted = list_fields(Settings{});
        wanted[name] = flag ? other : text ? "red" : std::to_string(1.25);
        INFO(name << " = " << other);
        CHECK(list_fields(voxelize::load_settings(file.path())) == wanted);
    }
}

TEST_CASE("every error in a settings file names field, value and what is allowed",
          "[voxelserver][voxelize][settings]") {
    struct Case {
        const char *name, *text, *message;
    };
    const auto c = GENERATE(values<Case>({
        {"an unknown section", "[roads]\n", "roads is no section; allowed: points, steps, "},
        {"an unknown field", "[points]\ndrop_all = true\n",
         "points.drop_all is unknown; allowed in [points]: drop_withheld, drop_overlap, "
         "drop_isolated"},
        {"a field of another section", "[bridges]\nsoil_m = 1\n",
         "bridges.soil_m is unknown; allowed in [bridges]: thickness_m, recognise, widest_m, "
         "min_drop_m, above_water_m, above_land_m"},
        {"no section", "soil_m = 1\n", "soil_m is no section; allowed: points, "},
        {"a number for a flag", "[steps]\nbridges = 1\n", "steps.bridges is not true or false"},
        {"a text for a number", "[ground]\nsoil_m = \"2\"\n",
         "ground.soil_m is no number; allowed: 0 to 100"},
        {"a flag for a number", "[ground]\nsoil_m = true\n",
         "ground.soil_m is no number; allowed: 0 to 100"},
        {"a number for a text", "[specialization]\npalette = 3\n",
         "specialization.palette is no text"},
        {"too large", "[buildings]\nstorey_m = 20.5\n",
         "buildings.storey_m = 20.5; allowed: 1 to 20"},
        {"too small", "[bridges]\nthickness_m = 0\n",
         "bridges.thickness_m = 0; allowed: 0.1 to 20"},
        {"below zero", "[water]\nslope = -0.25\n", "water.slope = -0.25; allowed: 0 to 10"},
        {"not a number at all", "[water]\nslope = nan\n", "water.slope = nan; allowed: 0 to 10"},
        {"endless", "[ground]\ndepth_m = inf\n", "ground.depth_m = inf; allowed: 0 to 10000"},
        {"depths the wrong way round", "[water]\nmin_depth_m = 9\n",
         "water.min_depth_m = 9 is above water.max_depth_m = 8"},
    }));
    DYNAMIC_SECTION(c.name) {
        const File file(c.text);
        CHECK_THROWS_AS(voxelize::load_settings(file.path()), util::UsageError);
        CHECK_THROWS_WITH(
            voxelize::load_settings(file.path()),
            contains("read the voxelization settings " + file.path().string() + ": " + c.message));
    }
}

TEST_CASE("a settings file that is missing or no TOML is named",
          "[voxelserver][voxelize][settings]") {
    CHECK_THROWS_AS(voxelize::load_settings("/nowhere/settings.toml"), util::UsageError);
    CHECK_THROWS_WITH(voxelize::load_settings("/nowhere/settings.toml"),
                      "read the voxelization settings /nowhere/settings.toml: no such file");
    CHECK_THROWS_WITH(voxelize::load_settings("/"),
                      "read the voxelization settings /: not a plain file");
    CHECK_THROWS_AS(voxelize::load_settings("/dev/zero"), util::UsageError);
    const File file("[points]\ndrop_withheld = \n");
    CHECK_THROWS_AS(voxelize::load_settings(file.path()), util::UsageError);
    CHECK_THROWS_WITH(voxelize::load_settings(file.path()),
                      contains(file.path().string()) && contains("(line 2)"));
}

TEST_CASE("each step is switched on and off by its name and no other",
          "[voxelserver][voxelize][settings]") {
    for (const StepSwitch& step : kStepSwitches) {
        INFO(step.name);
        Settings::Steps only;
        switch_steps(to_key(step), only);
        CHECK(on(only) == to_key(step));
        Settings::Steps others;
        switch_steps("-" + to_key(step), others);
        CHECK_FALSE(others.*step.on);
        others.*step.on = true;
        CHECK(on(others) == kAllOn);
    }
}

TEST_CASE("words choose steps from the left to the right", "[voxelserver][voxelize][settings]") {
    struct Case {
        const char* name;
        const char* text;
        std::string on;
    };
    const auto c = GENERATE(values<Case>({
        {"nothing said", "", "bridges,ground_fill"},
        {"all", "all", kAllOn},
        {"none", "none", ""},
        {"a list", "vegetation,building_fill", "building_fill,vegetation"},
        {"all but one",
         "all,-bridges,-vegetation,-colour_variation,-specialization,-neighbourhood_filters,"
         "-material_guesses",
         "water_equalization,water_deepening,ground_fill,building_fill"},
        {"without one, and with another", "-bridges,vegetation", "ground_fill,vegetation"},
        {"none, and then one", "none,vegetation", "vegetation"},
    }));
    DYNAMIC_SECTION(c.name) {
        Settings::Steps steps;
        switch_steps("bridges,ground_fill", steps);
        switch_steps(c.text, steps);
        CHECK(on(steps) == c.on);
    }
}

TEST_CASE("a word that is no step is refused with all that are allowed",
          "[voxelserver][voxelize][settings]") {
    struct Case {
        const char* name;
        const char* text;
        const char* word;
        const char* meant = "";
    };
    const auto c = GENERATE(values<Case>({
        {"unknown", "houses", "houses"},
        {"a step that is always run", "-coverage", "-coverage"},
        {"with spaces", "ground fill", "ground fill", " did you mean ground_fill?"},
        {"an empty word", "vegetation,", ""},
        {"a lone minus", "-", "-"},
        {"minus all", "-all", "-all", " did you mean all?"},
        {"the old name", "vegetation_fill", "vegetation_fill"},
    }));
    DYNAMIC_SECTION(c.name) {
        Settings::Steps steps;
        std::string message;
        try {
            switch_steps(c.text, steps);
        } catch (const util::UsageError& e) {
            message = e.what();
        }
        CHECK_THAT(message, contains("'" + std::string(c.word) + "' is no step;" + c.meant +
                                     " allowed: all, none, water_equalization, ") &&
                                contains("material_guesses, each step also with -"));
    }
}

TEST_CASE("the flag is stronger than the settings file", "[voxelserver][voxelize][settings]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "settings.toml";
    write_content(file, "[steps]\nbridges = false\nvegetation = false\n");
    CHECK_FALSE(load_settings(file).steps.bridges);
    CHECK(load_settings(file, "-ground_fill").steps.ground_fill == false);
    CHECK(load_settings(file, "-ground_fill").steps.bridges == false);
    CHECK(on(load_settings(file, "all").steps) == kAllOn);
    CHECK(on(load_settings(file, "bridges").steps) == "bridges");
    CHECK_THROWS_AS(load_settings(file, "houses"), util::UsageError);
}

TEST_CASE("the same steps have one fingerprint, however they are chosen, and others another",
          "[voxelserver][voxelize][settings]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "settings.toml";
    std::map<voxel::Fingerprint, std::string> seen;
    for (const StepSwitch& step : kStepSwitches) {
        write_content(file, "[steps]\n" + to_key(step) + " = false\n");
        const auto by_file = to_fingerprint(load_settings(file));
        CHECK(by_file == to_fingerprint(load_settings({}, "-" + to_key(step))));
        CHECK(seen.emplace(by_file, to_key(step)).second);
    }
    CHECK(seen.emplace(to_fingerprint(load_settings({})), "all").second);
}

TEST_CASE("the old name of a field is read, but not together with the new one",
          "[voxelserver][voxelize][settings]") {
    const TemporaryFolder folder;
    const auto file = folder.path() / "settings.toml";
    write_content(file, "[steps]\nvegetation_fill = false\n");
    CHECK_FALSE(load_settings(file).steps.vegetation);
    write_content(file, "[bridges]\nleast_drop_m = 2\n");
    CHECK(load_settings(file).bridges.min_drop_m == 2);
    write_content(file, "[steps]\nvegetation_fill = false\nvegetation = true\n");
    CHECK_THROWS_WITH(load_settings(file),
                      "read the voxelization settings " + file.string() +
                          ": steps.vegetation_fill is the old name of steps.vegetation, which is "
                          "given, too; allowed: one of them");
}
