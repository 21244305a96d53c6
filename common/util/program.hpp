#pragma once

#include <CLI/CLI.hpp>

#include <exception>
#include <iostream>
#include <optional>
#include <span>

#include "common/util/command_line.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/text.hpp"

namespace terravox::util {

/// Parses a program's arguments.
/// @return the exit code when --help, --version or the tables of options were requested (and
///         printed), nullopt to continue
/// @throws UsageError for arguments that the program does not accept
[[nodiscard]] inline std::optional<int> parse_arguments(CLI::App& app, int argc,
                                                        const char* const* argv) {
    if (wants_option_tables(argc, argv)) {
        std::cout << option_tables(app);
        return static_cast<int>(ExitCode::kDone);
    }
    const std::span arguments(argv + 1, argc > 1 ? static_cast<std::size_t>(argc) - 1 : 0);
    refuse_misread_arguments(app, arguments);
    try {
        app.parse(argc, argv);
        return std::nullopt;
    } catch (const CLI::CallForHelp&) {
        std::cout << help_text(app, arguments);
        return static_cast<int>(ExitCode::kDone);
    } catch (const CLI::Success& exit) {
        return app.exit(exit);
    } catch (const CLI::ParseError& e) {
        throw UsageError(usage_message(app, e, arguments));
    }
}

/// The one place where a program's errors are caught: prints one line on standard error that begins
/// with `terravox: `, and returns the exit code.
/// @param body int(): the whole program
template <class Body>
[[nodiscard]] int run_program(const Body& body) noexcept {
    end_with_a_line_on_uncaught_exceptions();
    auto code = ExitCode::kFailed;
    try {
        const int done = body();
        say_shared_warnings();
        return done;
    } catch (const Error& e) {
        say_shared_warnings();
        code = e.exit_code();
        std::cerr << "terravox: " << printable(e.what()) << "\n";
    } catch (...) {
        std::cerr << "terravox: " << printable(to_message(std::current_exception())) << "\n";
    }
    return static_cast<int>(code);
}

}  // namespace terravox::util
