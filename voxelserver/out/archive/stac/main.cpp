#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>

#include "common/util/command_line.hpp"
#include "voxelserver/out/archive/stac/stac.hpp"
#include "voxelserver/out/archive/stac_command.hpp"

namespace {

using namespace terravox;

util::ExitCode describe(const archive_tools::StacArguments& arguments) {
    const stac::StacReport written =
        stac::write_stac({{arguments.archives.begin(), arguments.archives.end()},
                          arguments.folder,
                          stac::stac_time(arguments.datetime),
                          arguments.href,
                          arguments.collection,
                          arguments.overwrite});
    for (const std::filesystem::path& file : written.files)
        std::cout << file.string() << "\n";
    return written.holes > 0 ? util::ExitCode::kHoles : util::ExitCode::kDone;
}

std::function<util::ExitCode()> add_options(CLI::App& app) {
    const auto arguments = std::make_shared<archive_tools::StacArguments>();
    archive_tools::add_stac_options(app, *arguments);
    return [arguments] { return describe(*arguments); };
}

}  // namespace

int main(int argc, char** argv) {
    return util::run_command_program(archive_tools::kStac, argc, argv, add_options);
}
