#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/bench.hpp"

namespace terravox::bench {

/// The entries serve/..., view/..., grab/... and paper/... : a Python script in tests/bench starts
/// the real programs, loads them, and ends with its figures, one line of JSON.

/// Why such an entry cannot run here; empty = it can. @param others programs it needs besides the
/// server, the survey's maker and Python
[[nodiscard]] std::string missing_for_serving(const Context& context,
                                              const std::vector<std::string>& others = {});

/// Why the grabber cannot be measured here; empty = it can.
[[nodiscard]] std::string missing_for_grabbing();

/// Runs tests/bench/NAME.py. @throws Error with its last line when it fails, or when that line is
/// no JSON
[[nodiscard]] nlohmann::json run_script(const Context& context, const std::string& name,
                                        const std::vector<std::string>& arguments);
/// Runs tests/bench/serve/NAME.py. @throws Error with its last line when it fails, or when that
/// line is no JSON
[[nodiscard]] nlohmann::json run_serve_script(const Context& context, const std::string& name,
                                              const std::vector<std::string>& arguments = {});

}  // namespace terravox::bench
