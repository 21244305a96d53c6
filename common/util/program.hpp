#pragma once

#include <CLI/CLI.hpp>

#include <exception>
#include <iostream>
#include <new>
#include <optional>
#include <string>

#include "common/util/error.hpp"

namespace terravox::util {

/// Reads a program's arguments.
/// @return the exit code when --help or --version was asked for (and answered), nullopt to go on
/// @throws UsageError for arguments that the program does not take
[[nodiscard]] inline std::optional<int> parse_arguments(CLI::App& app, int argc, const char* const* argv) {
    try {
        app.parse(argc, argv);
        return std::nullopt;
    } catch (const CLI::Success& asked) {
        return app.exit(asked);
    } catch (const CLI::ParseError& e) {
        throw UsageError(std::string(e.what()) + "; --help lists what is allowed");
    }
}

/// The one place where a program's errors end: one line on standard error that begins with `terravox: `, and the exit code.
/// @param body int(): the whole program
template <class Body> [[nodiscard]] int run_program(const Body& body) noexcept {
    try {
        return body();
    } catch (const Error& e) {
        std::cerr << "terravox: " << e.what() << "\n";
        return static_cast<int>(e.exit_code());
    } catch (const std::bad_alloc&) {
        std::cerr << "terravox: out of memory; lower memory limits or a smaller task may help\n";
    } catch (const std::exception& e) {
        std::cerr << "terravox: " << e.what() << "\n";
    }
    return static_cast<int>(ExitCode::kFailed);
}

}  // namespace terravox::util
