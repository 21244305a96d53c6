#pragma once

#include <string>

#include "voxelserver/out/country/plan.hpp"

namespace terravox::commands {

/// A plan in lines for people, without its missing squares.
[[nodiscard]] std::string text_of(const country::Plan& plan);
/// What it foresees as a JSON object, with its missing squares.
/// @param folder of the plan
[[nodiscard]] std::string json_of(const country::Plan& plan, const std::string& folder);

}  // namespace terravox::commands
