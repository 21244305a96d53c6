// Steps chosen by name.
#include "voxelserver/make/voxelize/points/settings.hpp"

#include <filesystem>
#include <fstream>
#include <map>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::test;
using namespace terravox::voxelize;

namespace {

/// The keys of the steps that are on, in order, with commas.
std::string on(const Settings::Steps& steps) {
    std::string out;
    for (const StepSwitch& step : kStepSwitches)
        if (steps.*step.on)
            out += (out.empty() ? "" : ",") + to_key(step);
    return out;
}

void write_text(const std::filesystem::path& file, const std::string& text) {
    std::ofstream(file) << text;
}

const std::string kAllOn =
    "water_equalization,water_deepening,bridges,ground_fill,building_fill,vegetation,"
    "colour_variation,specialization,neighbourhood_filters,material_guesses";

}  // namespace

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
    write_text(file, "[steps]\nbridges = false\nvegetation = false\n");
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
        write_text(file, "[steps]\n" + to_key(step) + " = false\n");
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
    write_text(file, "[steps]\nvegetation_fill = false\n");
    CHECK_FALSE(load_settings(file).steps.vegetation);
    write_text(file, "[bridges]\nleast_drop_m = 2\n");
    CHECK(load_settings(file).bridges.min_drop_m == 2);
    write_text(file, "[steps]\nvegetation_fill = false\nvegetation = true\n");
    CHECK_THROWS_WITH(load_settings(file),
                      "read the voxelization settings " + file.string() +
                          ": steps.vegetation_fill is the old name of steps.vegetation, which is "
                          "given, too; allowed: one of them");
}

TEST_CASE("the help has a line for each step", "[voxelserver][voxelize][settings]") {
    const std::string help = steps_help();
    for (const StepSwitch& step : kStepSwitches) {
        CHECK(help.find("\n  " + to_key(step) + " ") != std::string::npos);
        CHECK(help.find(" " + std::string(step.doc)) != std::string::npos);
    }
}
