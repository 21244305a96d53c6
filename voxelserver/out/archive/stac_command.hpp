#pragma once

#include <string>
#include <vector>

#include "common/util/command_line.hpp"

namespace terravox::archive_tools {

/// `terravox archive stac`: a program of its own, since it alone needs coordinate systems.
inline constexpr util::CommandWithProgram kStac{
    "stac", "terravox-stac",
    "describe archives for catalogues: a STAC item for each, and a collection", "terravox archive"};

struct StacArguments {
    std::vector<std::string> archives;
    std::string folder;
    std::string datetime;
    std::string href;
    std::string collection;
    bool overwrite = false;
};

/// @param app the program, or the command in the list of terravox-archive
/// @param arguments must outlive the parsing
void add_stac_options(CLI::App& app, StacArguments& arguments);

}  // namespace terravox::archive_tools
