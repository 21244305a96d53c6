#include "common/util/command_line.hpp"

#include <CLI/CLI.hpp>

#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/program.hpp"
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
