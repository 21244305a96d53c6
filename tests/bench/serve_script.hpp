#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tests/bench/bench.hpp"

namespace terravox::bench {

/// The entries library/..., serve/..., view/..., grab/... and paper/... : a Python script in
/// tests/bench starts the real programs, loads them, and ends with its figures, one line of JSON.

/// Why such an entry cannot run here; empty = it can. @param others programs it needs besides the
/// server, the survey's maker and Python
[[nodiscard]] std::string missing_for_serving(const Context& context,
                                              const std::vector<std::string>& others = {});

/// Why the grabber cannot be measured here; empty = it can.
[[nodiscard]] std::string missing_for_grabbing();

/// The folder of the Python package that was built with the programs, for PYTHONPATH.
[[nodiscard]] std::filesystem::path python_package(const Context& context);
/// The interpreter that the package was built for; empty where it was not built.
[[nodiscard]] std::string package_python();

/// Runs tests/bench/NAME.py. @throws Error with its last line when it fails, or when that line is
/// no JSON
/// @param python the interpreter, looked up in PATH without a slash
[[nodiscard]] nlohmann::json run_script(const Context& context, const std::string& name,
                                        const std::vector<std::string>& arguments,
                                        const std::string& python = "python3");
/// Runs tests/bench/serve/NAME.py. @throws Error with its last line when it fails, or when that
/// line is no JSON
[[nodiscard]] nlohmann::json run_serve_script(const Context& context, const std::string& name,
                                              const std::vector<std::string>& arguments = {});

}  // namespace terravox::bench
