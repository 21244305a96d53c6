#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raytracer/core/scene/scene.hpp"
#include "raytracer/farm/render/render_pool.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// Flags for the credentials of a program of the farm.
struct CredentialArguments {
    std::string token_file;
    std::string ca;
    std::string certificate;
    std::string key;

    /// The credentials given by flags or in the environment; nullopt: none.
    /// @throws UsageError, Error
    [[nodiscard]] std::optional<net::Credentials> find() const;
    /// @param listens if there is no token, one is made and printed on standard error, where `how`
    /// explains its use
    /// @throws UsageError, Error
    [[nodiscard]] net::Credentials credentials(bool listens, const std::string& how) const;
};
void add_credential_arguments(CLI::App& command, CredentialArguments& args);

/// Flags for what renders.
struct RenderPoolArguments {
    std::vector<std::string> workers;
    std::string listen;
    std::string give_up;
    bool green = false;
    CredentialArguments credentials;

    /// @throws UsageError, Error
    [[nodiscard]] render::RenderPoolOptions options(const scene::Scene& scene) const;
};
/// Adds the flags to a command. `args` must outlive the parsing.
void add_render_pool_arguments(CLI::App& command, RenderPoolArguments& args);

/// Parses a duration such as 90, 90s, 5m or 2h.
/// @throws UsageError naming the flag
[[nodiscard]] std::chrono::milliseconds parse_time(const std::string& flag,
                                                   const std::string& text);

}  // namespace terravox::commands
