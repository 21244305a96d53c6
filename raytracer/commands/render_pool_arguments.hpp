#pragma once

#include <optional>
#include <string>
#include <vector>

#include "raytracer/render/render_pool.hpp"
#include "raytracer/scene/scene.hpp"

namespace CLI {
class App;
}

namespace terravox::commands {

/// How a program of the farm shows that it may, as flags.
struct CredentialArguments {
    std::string token_file, ca, certificate, key;

    /// What is named, or in the environment; nullopt: nothing is. @throws UsageError, Error
    [[nodiscard]] std::optional<net::Credentials> find() const;
    /// @param listens without any token one is made, and told on standard error, where `how` says
    /// what to do with it
    /// @throws UsageError, Error
    [[nodiscard]] net::Credentials credentials(bool listens, const std::string& how) const;
};
void add_credential_arguments(CLI::App& command, CredentialArguments& args);

/// Who renders, as flags.
struct RenderPoolArguments {
    std::vector<std::string> workers;
    std::string listen, give_up;
    bool discover = false, green = false;
    CredentialArguments credentials;

    /// @throws UsageError, Error
    [[nodiscard]] render::RenderPoolOptions options(const scene::Scene& scene) const;
};
/// `args` must outlive the parsing.
void add_render_pool_arguments(CLI::App& command, RenderPoolArguments& args);

/// A span of time such as 90, 90s, 5m or 2h. @throws UsageError naming the flag
[[nodiscard]] std::chrono::milliseconds parse_time(const std::string& flag,
                                                   const std::string& text);

}  // namespace terravox::commands
