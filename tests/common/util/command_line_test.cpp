#include <algorithm>
#include <CLI/CLI.hpp>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "common/util/command_line.hpp"
#include "common/util/error.hpp"
#include "common/util/program.hpp"
#include "common/util/text.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using terravox::test::contains;

namespace {

/// A program with the kinds of options that the commands have.
struct Program {
    Program() {
        app.require_subcommand(1);
        render = app.add_subcommand("render", "Render a world");
        render->add_option("-o,--output", outputs, "picture to write")
            ->required()
            ->expected(1)
            ->take_all()
            ->allow_extra_args(false);
        render->add_option("inputs", inputs, "LAZ files")->required();
        render->add_option("--ortho", orthophotos, "orthophoto")
            ->expected(1)
            ->take_all()
            ->allow_extra_args(false);
        render->add_option("--output-size,--size", size, "WIDTHxHEIGHT");
        render->add_option("--level", level, "of the voxels")->check(CLI::Range(0, 20));
        render->add_option("--count", level, "how many");
        render->add_option("--photo", photo, "colours")->check(CLI::IsMember({"albedo", "raw"}));
        CLI::Option* const quiet = render->add_flag("-q,--quiet", is_quiet, "errors only");
        render->add_flag("-v,--verbose", is_verbose, "all")->excludes(quiet);
        render->add_option("--camera-zoom,--zoom", zoom, "nearer")->group("Scene: camera");
        render->add_option("--listen", listen, "address")->group("Farm");
        render->add_option("--former", listen, "a former name")->group("");
        util::refuse_removed_option(*render, "--gone", "--listen");
        CLI::App* const forward = app.add_subcommand("forward", "Render elsewhere");
        forward->add_option("--image", photo, "of a container")->required();
        forward->prefix_command();
        CLI::App* const analyse = app.add_subcommand("analyse", "Measure a world");
        analyse->require_subcommand(1);
        analyse->add_subcommand("sky", "Measure the sky");
        analyse->add_subcommand("sun", "Measure the sun");
    }

    /// @throws UsageError
    void parse(std::vector<const char*> arguments) {
        arguments.insert(arguments.begin(), "terravox");
        (void)util::parse_arguments(app, static_cast<int>(arguments.size()), arguments.data());
    }

    /// What --help prints.
    std::string help(std::vector<const char*> arguments) {
        try {
            std::vector<const char*> all = arguments;
            all.insert(all.begin(), "terravox");
            app.parse(static_cast<int>(all.size()), all.data());
        } catch (const CLI::CallForHelp&) {
            return util::help_text(app, arguments);
        }
        return "no help was requested";
    }

    CLI::App app{"Makes pictures", "terravox"};
    CLI::App* render = nullptr;
    std::vector<std::string> inputs;
    std::vector<std::string> outputs;
    std::vector<std::string> orthophotos;
    std::string size;
    std::string photo;
    std::string listen;
    int level = 0;
    double zoom = 1;
    bool is_quiet = false;
    bool is_verbose = false;
};

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

const std::vector<std::string> kKnown = {"render",  "convert",  "serve",         "survey",
                                         "--ortho", "--output", "--output-size", "material"};

}  // namespace

TEST_CASE("a refused command line says what is meant or allowed", "[common][util][command_line]") {
    struct Case {
        const char* line;
        const char* said;
    };
    const auto c = GENERATE(values<Case>({
        {"", "a command is missing; allowed: render, forward, analyse"},
        {"rendr x.laz",
         "unknown command 'rendr'; did you mean render? allowed: render, forward, analyse"},
        {"paint", "unknown command 'paint'; allowed: render, forward, analyse"},
        {"analyse", "analyse: a command is missing; allowed: sky, sun"},
        {"analyse skyy", "analyse: unknown command 'skyy'; did you mean sky? allowed: sky, sun"},
        {"analyse skyy x.laz -o a.tif",
         "analyse: unknown command 'skyy'; did you mean sky? allowed: sky, sun"},
        {"analyse skyy -- render",
         "analyse: unknown command 'skyy'; did you mean sky? allowed: sky, sun"},
        {"analyse --fast", "analyse: unknown option --fast; --help lists every option"},
        {"-o a render x", "render: the option -o stands before the command; allowed: behind it"},
        {"render", "render: inputs are missing: LAZ files"},
        {"render -o a", "render: inputs are missing: LAZ files"},
        {"render x", "render: --output is missing: picture to write"},
        {"render x --outptu a", "render: unknown option --outptu; did you mean --output?"},
        {"render x -o a --otho b", "render: unknown option --otho; did you mean --ortho?"},
        {"render x -o a --otho=b", "render: unknown option --otho; did you mean --ortho?"},
        {"render x -o a --frobnicate",
         "render: unknown option --frobnicate; --help lists every option"},
        {"render x -o a --forme", "render: unknown option --forme; --help lists every option"},
        {"render x -output a", "render: unknown option -output; did you mean --output?"},
        {"render x -o a -zoom 2", "render: unknown option -zoom; did you mean --zoom?"},
        {"--size 4x4 render x",
         "render: the option --size stands before the command; allowed: behind it"},
        {"render x -o a --zoom", "render: --zoom: its value is missing: nearer"},
        {"render x -o a --size --level 3",
         "render: --size: its value is missing, --level follows; allowed: WIDTHxHEIGHT"},
        {"render x -o a --photo rw",
         "render: --photo = 'rw'; did you mean raw? allowed: albedo, raw"},
        {"render x -o a --level 21", "render: --level = '21'; allowed: 0 to 20"},
        {"render x -o a --count many", "render: --count = 'many'; allowed: a whole number"},
        {"render x -o a --zoom near", "render: --zoom = 'near'; allowed: a number"},
        {"render x -o a --size 1x1 --output-size 2x2",
         "render: --output-size, --size: given 2 times; allowed: once"},
        {"render x -o a -v --quiet", "render: --quiet and -v are given; allowed: one of them"},
        {"forward render --fast", "forward: --image is missing: of a container"},
        {"analyse sky blue",
         "analyse sky: unexpected argument 'blue'; --help shows what is allowed"},
    }));
    DYNAMIC_SECTION("terravox " << c.line) {
        std::istringstream words(c.line);
        const std::vector<std::string> arguments{std::istream_iterator<std::string>(words), {}};
        std::vector<const char*> given;
        for (const std::string& argument : arguments)
            given.push_back(argument.c_str());
        Program program;
        CHECK_THROWS_WITH(program.parse(given), std::string(c.said));
        CHECK_THROWS_AS(Program().parse(given), util::UsageError);
    }
}

TEST_CASE("an option of an earlier version says what serves instead",
          "[common][util][command_line]") {
    CHECK_THROWS_WITH(Program().parse({"render", "x", "-o", "a", "--gone"}),
                      "--gone was removed; allowed: --listen");
}

TEST_CASE("what looks like a mistake and is none is accepted", "[common][util][command_line]") {
    struct Case {
        const char* name;
        std::vector<const char*> arguments;
    };
    const auto c = GENERATE(values<Case>({
        {"a negative number", {"render", "x", "-o", "a", "--zoom", "-2"}},
        {"a value attached to a short option", {"render", "x", "-oa.png"}},
        {"a value that begins with a hyphen", {"render", "x", "-o", "a", "--size", "-ortho"}},
        {"an input with the name of a command", {"render", "analyse", "-o", "a"}},
        {"an input behind --", {"render", "-o", "a", "--", "-output"}},
    }));
    DYNAMIC_SECTION(c.name) {
        Program program;
        CHECK_NOTHROW(program.parse(c.arguments));
        CHECK(program.inputs.size() == 1);
    }
}

TEST_CASE("help begins with the options that are used most", "[common][util][command_line]") {
    Program program;
    util::list_first(*program.render, {"--output", "--size"});
    SECTION("--help") {
        const std::string text = program.help({"render", "--help"});
        CHECK_THAT(text, contains("Usage: terravox render") && contains("LAZ files") &&
                             contains("picture to write") && contains("--output-size,--size") &&
                             contains("options (6), camera (1), farm (1)"));
        CHECK_THAT(text, !contains("--ortho") && !contains("--zoom"));
    }
    SECTION("--help all") {
        const std::string text = program.help({"render", "--help", "all"});
        for (const char* option : {"--output", "--size", "--ortho", "--zoom", "--listen"})
            CHECK_THAT(text, contains(option));
        CHECK_THAT(text, !contains("--former"));
    }
    SECTION("--help GROUP") {
        for (const char* word : {"camera", "Camera"}) {
            const std::string text = program.help({"render", "-h", word});
            CHECK_THAT(text, contains("--zoom") && !contains("--size") && !contains("--listen"));
        }
    }
    SECTION("another word") {
        CHECK_THROWS_WITH(
            program.help({"render", "--help", "camra"}),
            "render: --help camra; did you mean camera? allowed: all, options, camera, farm");
    }
    SECTION("an option follows") {
        CHECK(program.help({"render", "--help", "-o", "a"}) == program.help({"render", "--help"}));
    }
}

TEST_CASE("help of a command without such a group is whole", "[common][util][command_line]") {
    Program program;
    CHECK_THAT(program.help({"render", "--help"}), contains("--zoom") && contains("--ortho"));
    CHECK(program.help({"render", "--help", "x"}) == program.help({"render", "--help"}));
    CHECK_THAT(program.help({"--help"}), contains("Render a world") && contains("Measure a world"));
}

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

TEST_CASE("a range is one number or two", "[util][range]") {
    CHECK(util::parse_range("--frames", "4-9", {0, 9}) == util::IntRange{4, 9});
    CHECK(util::parse_range("--frames", "0", {0, 9}) == util::IntRange{0, 0});
    const auto wrong =
        GENERATE(values<std::string>({"", "-", "4-", "-4", "9-4", "4-10", "x", "4-9x", "4 9",
                                      "99999999999", "4-99999999999", "1.5", "0x3", "4--9", "+4"}));
    DYNAMIC_SECTION("not '" << wrong << "'") {
        CHECK_THROWS_AS(util::parse_range("--frames", wrong, {0, 9}), util::UsageError);
        CHECK_THROWS_WITH(util::parse_range("--frames", wrong, {0, 9}),
                          test::contains("from 0 to 9"));
    }
}

TEST_CASE("a number's text is the shortest that reads back as it", "[common][util][text]") {
    using namespace terravox::util;
    CHECK(number_text(0.1) == "0.1");
    CHECK(number_text(0.1F) == "0.1");
    CHECK(number_text(100000.0) == "1e+05");
    CHECK(number_text(1.0 / 3) == "0.3333333333333333");
    CHECK(number_text(-std::numeric_limits<double>::denorm_min()) == "-5e-324");
    CHECK(number_text(1.0 / 3, 6) == "0.333333");
    CHECK(number_text(1234567.0, 6) == "1.23457e+06");
    CHECK(number_text(2.0, 15) == "2");
    CHECK(number_text(std::numeric_limits<double>::infinity(), 15) == "inf");
    CHECK(plain_number_text(100000.0) == "100000");
    CHECK(plain_number_text(1e-7) == "0.0000001");
    CHECK(plain_number_text(1e-300) == "1e-300");
}

TEST_CASE("the distance of two texts counts the edits between them", "[common][util][near_words]") {
    CHECK(util::edit_distance("kitten", "sitting") == 3);
    CHECK(util::edit_distance("", "abc") == 3);
    CHECK(util::edit_distance("abc", "abc") == 0);
    CHECK(util::edit_distance("abc", "acb") == 1);
    CHECK(util::edit_distance("ca", "abc") == 3);  // no byte is changed twice
}

TEST_CASE("a mistyped word is near the one that was meant", "[common][util][near_words]") {
    struct Case {
        const char* name;
        const char* mistyped;
        std::vector<std::string> near;
    };
    const auto c = GENERATE(values<Case>({
        {"a letter left out", "rendr", {"render"}},
        {"a letter too many", "rennder", {"render"}},
        {"another letter", "sender", {"render"}},
        {"neighbours swapped", "--otrho", {"--ortho"}},
        {"capital letters", "Render", {"render"}},
        {"one hyphen", "-ortho", {"--ortho"}},
        {"no hyphen", "output", {"--output"}},
        {"a short form", "--out", {"--output"}},
        {"the beginning of a long word", "mater", {"material"}},
        {"the beginning of too short a word", "ma", {}},
        {"two equally near", "serv", {"serve"}},
        {"as near to two", "surve", {"serve", "survey"}},
        {"three letters of a short word", "sky", {}},
        {"nothing alike", "--frobnicate", {}},
        {"nothing", "", {}},
        {"hyphens alone", "--", {}},
    }));
    DYNAMIC_SECTION(c.name) {
        CHECK(util::near_words(c.mistyped, kKnown) == c.near);
    }
}

TEST_CASE("a message names what was meant and what is allowed", "[common][util][near_words]") {
    const std::vector<std::string> known = {"serve", "survey"};
    CHECK(util::did_you_mean("surve", known) == "; did you mean serve or survey?");
    CHECK(util::did_you_mean("survei", known) == "; did you mean survey?");
    CHECK(util::did_you_mean("paint", known).empty());
    CHECK(util::allowed_words("survei", known) == "; did you mean survey? allowed: serve, survey");
    CHECK(util::allowed_words("paint", known) == "; allowed: serve, survey");
}
