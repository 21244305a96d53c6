#include "common/util/command_line.hpp"

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/catch.hpp"

using namespace terravox;

namespace {

nlohmann::json make_table(const CLI::App& app) {
    return nlohmann::json::parse(util::option_tables(app));
}

/// The option with this name, or the positional one of this name.
nlohmann::json find_option(const nlohmann::json& table, const std::string& name) {
    for (const nlohmann::json& option : table["options"]) {
        const auto names = option["names"].get<std::vector<std::string>>();
        if (option["positional"] == name ||
            std::find(names.begin(), names.end(), name) != names.end())
            return option;
    }
    return nullptr;
}

}  // namespace

TEST_CASE("a table holds what help says of a program and its commands",
          "[common][util][option_tables]") {
    CLI::App app{"makes things", "thing"};
    std::string text = "blue";
    std::vector<std::string> inputs;
    bool is_wet = false;
    CLI::App* const command = app.add_subcommand("paint", "paints a thing");
    command->footer("It dries.");
    command->add_option("-c,--colour,--color", text, "its colour")->capture_default_str();
    command->add_option("inputs", inputs, "things")->required();
    command->add_flag("--wet", is_wet, "still wet")->group("State");
    command->add_option("--old-name", text, "former name")->group("");

    const nlohmann::json table = make_table(app);
    CHECK(table["name"] == "thing");
    CHECK(table["description"] == "makes things");
    REQUIRE(table["commands"].size() == 1);
    const nlohmann::json& paint = table["commands"][0];
    CHECK(paint["name"] == "paint");
    CHECK(paint["footer"] == "It dries.");

    const nlohmann::json colour = find_option(paint, "--colour");
    CHECK(colour["names"] == std::vector<std::string>{"-c", "--colour", "--color"});
    CHECK(colour["default"] == "blue");
    CHECK(colour["value"] == "TEXT");
    CHECK(colour["repeats"] == false);
    CHECK(colour["required"] == false);
    const nlohmann::json input = find_option(paint, "inputs");
    CHECK(input["names"].empty());
    CHECK(input["repeats"] == true);
    CHECK(input["required"] == true);
    const nlohmann::json wet = find_option(paint, "--wet");
    CHECK(wet["value"] == "");
    CHECK(wet["group"] == "State");
    CHECK(find_option(paint, "--old-name") == nullptr);
    CHECK(find_option(paint, "--help") != nullptr);
}

TEST_CASE("the values of an option are found where help lists them",
          "[common][util][option_tables]") {
    struct Case {
        const char* name;
        const char* type;
        const char* text;
        std::vector<std::string> words;
    };
    const auto c = GENERATE(values<Case>({
        {"a switch", "yes|no", "whether", {"yes", "no"}},
        {"a list", "TEXT", "trace, debug or off", {"trace", "debug", "off"}},
        {"in brackets", "VALUE", "tone (auto, b-c, d2), default 'auto'", {"auto", "b-c", "d2"}},
        {"behind others", "VALUE", "x (1 to 2) (crs, voxel)", {"crs", "voxel"}},
        {"a range", "VALUE", "size (0 to 1), default 0.5", {}},
        {"one word", "VALUE", "size (metres)", {}},
        {"sentences", "VALUE", "a folder (made when missing, else read)", {}},
        {"not closed", "VALUE", "size (a, b", {}},
        {"examples", "TEXT", "an address (east, north)", {}},
        {"nothing", "TEXT", "", {}},
    }));
    DYNAMIC_SECTION(c.name) {
        CLI::App app;
        std::string value;
        app.add_option("--option", value, c.text)->type_name(c.type);
        CHECK(find_option(make_table(app), "--option")["words"] == c.words);
    }
    SECTION("checked words") {
        CLI::App app;
        std::string value;
        app.add_option("--option", value, "a surface")->check(CLI::IsMember({"dtm", "dsm"}));
        CHECK(find_option(make_table(app), "--option")["words"] ==
              std::vector<std::string>{"dtm", "dsm"});
    }
}

TEST_CASE("only the whole command line asks for tables", "[common][util][option_tables]") {
    const char* const alone[] = {"program", "--option-tables"};
    const char* const second[] = {"program", "render", "--option-tables"};
    CHECK(util::wants_option_tables(2, alone));
    CHECK_FALSE(util::wants_option_tables(3, second));
    CHECK_FALSE(util::wants_option_tables(1, alone));
}
