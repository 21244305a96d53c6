#include "common/util/program_of_command.hpp"

#include <unistd.h>
#include <CLI/CLI.hpp>

#include <cerrno>
#include <cstring>
#include <string>

#include "common/util/beside_program.hpp"
#include "common/util/program.hpp"
#include "common/util/version.hpp"

namespace terravox::util {

int run_program_of(const CommandWithProgram& command, int argc, char** argv,
                   const AddOptions& add_options) {
    return run_program([&] {
        CLI::App app{command.description, std::string(command.listed_by) + " " + command.name};
        app.set_version_flag("--version", std::string("terravox ") + kVersion);
        const auto run = add_options(app);
        if (const auto answered = parse_arguments(app, argc, argv))
            return *answered;
        return static_cast<int>(run());
    });
}

void list_command(CLI::App& app, const CommandWithProgram& command) {
    app.add_subcommand(command.name, command.description);
}

void go_on_as(const CommandWithProgram& command, int argc, char** argv) {
    if (argc < 2 || std::string_view(argv[1]) != command.name)
        return;
    std::string program = beside_program(command.program).string();
    argv[1] = program.data();
    ::execv(program.c_str(), argv + 1);
    throw Error(std::string("run ") + command.name + ": cannot start " + program + ": " +
                std::strerror(errno) + "; it belongs in the folder of this program");
}

}  // namespace terravox::util
