#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/bench.hpp"

namespace terravox::bench {

/// Why programs of the project cannot be run: one is not in the folder of the context. Empty = they
/// can.
[[nodiscard]] std::string missing_programs(const Context& context,
                                           const std::vector<std::string>& names);

/// Runs a program to its end. @param output file that takes what it says
/// @throws Error with its last line when it fails
ChildOutcome run_program(const Context& context, const std::vector<std::string>& command,
                         const std::filesystem::path& output);

/// The demo's square kilometre, a synthetic survey with orthophotos: made once in a run of the
/// bench. @throws Error
[[nodiscard]] std::filesystem::path demo_survey(const Context& context);

// The entries farm/..., grab/..., preview/..., serve/... and view/...: a Python script in
// tests/bench starts the real programs, loads them, and ends with its figures, one line of JSON.

/// Why such an entry cannot run here; empty = it can. @param others programs it needs besides the
/// server, the survey's maker and Python
[[nodiscard]] std::string missing_for_serving(const Context& context,
                                              const std::vector<std::string>& others = {});

/// Why the grabber cannot be measured here; empty = it can.
[[nodiscard]] std::string missing_for_grabbing();

/// Runs tests/bench/NAME.py. @throws Error with its last line when it fails, or when that line is
/// no JSON
[[nodiscard]] nlohmann::json run_script(const Context& context, const std::string& name,
                                        const std::vector<std::string>& arguments = {});

}  // namespace terravox::bench
