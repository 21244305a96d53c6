#pragma once

#include "common/util/command_line.hpp"

namespace terravox::commands {

/// The commands of terravox-raytracer that are programs of their own.
inline constexpr util::CommandWithProgram kConvert{
    "convert", "terravox-convert",
    "Convert a world to a box archive, a Minecraft world, or another program's format"};
inline constexpr util::CommandWithProgram kPublish{
    "publish", "terravox-publish",
    "Make a web site of a world, which any static host serves and any browser shows"};
inline constexpr util::CommandWithProgram kView{
    "view", "terravox-view", "Show a site, or a world as one, to a browser of this machine"};
inline constexpr util::CommandWithProgram kPreview{
    "preview", "terravox-preview",
    "Fly around a world in a window while it is rendered, coarse to fine"};

}  // namespace terravox::commands
