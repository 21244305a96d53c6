#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/farm/net/endpoint.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"

namespace CLI {
class App;
}

namespace terravox::farm {

/// The configuration of a worker daemon: from a file (config/worker.toml), and from flags of the
/// same names, which override it.
struct WorkerConfig {
    std::optional<sockets::Address> listen;  ///< for coordinators that dial
    std::vector<sockets::Address> join;      ///< coordinators that listen
    std::string name;                        ///< for display; empty: host and process
    int threads = 0;                         ///< per session; 0: one for each core
    int memory_mib = 2048;                   ///< for boxes, of all sessions
    int sessions = 1;                        ///< simultaneous coordinators
    std::filesystem::path token_file;        ///< empty: environment variable TERRAVOX_FARM_TOKEN
    std::filesystem::path tls_ca, tls_cert, tls_key;  ///< PEM; all three, or none
    /// Servers of boxes that coordinators may refer it to, if they resolve to public addresses.
    std::vector<remote::HttpOrigin> allow_origins;
    /// Servers that may also resolve to private and loopback addresses.
    std::vector<remote::HttpOrigin> allow_private_origins;
    /// The server that gets the token of server_token_file.
    std::optional<remote::HttpOrigin> server_origin;
    std::filesystem::path server_token_file;  ///< set only together with server_origin
    std::optional<sockets::Address> metrics;  ///< of the page of metrics; its host is numeric
    std::string metrics_names;                ///< host names of that page, separated by blanks
    double drain_s = 10;                      ///< time for tiles under way when it is stopped
    double idle_s = 0;  ///< it ends when no coordinator has connected for this long; 0: never
    bool once = false;  ///< it ends with its first coordinator
    std::string log = "info";  ///< as for util::set_up_log
    bool log_json = false;
};

/// The arguments of the command line.
struct WorkerArguments {
    std::filesystem::path file;                               ///< empty: no file
    std::vector<std::pair<std::string, std::string>> fields;  ///< name and text, in the order given
};

/// Adds the flags to a command. `arguments` must outlive the parsing.
void add_worker_options(CLI::App& app, WorkerArguments& arguments);

/// Loads the file, if any, with the flags over it; several --join replace those of the file. Paths
/// in a file are relative to the file. To be called again to reload.
/// @throws UsageError for what cannot be read, is unknown, out of range, or inconsistent
[[nodiscard]] WorkerConfig load_worker_config(const WorkerArguments& arguments);

/// The token, read anew each time, or the paths of the certificates.
/// @throws Error for a token that cannot be read; UsageError where there is neither, or both
[[nodiscard]] net::Credentials make_credentials(const WorkerConfig& config);

/// The servers that the worker may request from, and the token of one of them. The environment is
/// not used.
/// @throws Error for a token that cannot be read
[[nodiscard]] remote::HttpAccess make_http_access(const WorkerConfig& config);

/// How a reload differs from the running configuration, by names of fields in the order of
/// WorkerConfig.
struct WorkerConfigChange {
    std::vector<std::string> now;      ///< take effect at once
    std::vector<std::string> restart;  ///< take effect at the next start
    friend bool operator==(const WorkerConfigChange&, const WorkerConfigChange&) = default;
};
[[nodiscard]] WorkerConfigChange difference(const WorkerConfig& running,
                                            const WorkerConfig& wanted);
/// The configuration after a reload: fields that may change at once have the wanted values, the
/// others their previous ones.
[[nodiscard]] WorkerConfig reloaded(const WorkerConfig& running, const WorkerConfig& wanted);

}  // namespace terravox::farm
