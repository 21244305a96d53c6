#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/farm/net/endpoint.hpp"
#include "voxelserver/worlds/remote/http_access.hpp"

namespace CLI {
class App;
}

namespace terravox::farm {

/// Everything that a worker daemon is told: by a file (config/worker.toml), and by flags of the
/// same names over it.
struct WorkerConfig {
    std::optional<sockets::Address> listen;  ///< for coordinators that dial
    std::vector<sockets::Address> join;      ///< coordinators that listen
    bool announce = false;                   ///< where it listens, by multicast DNS
    std::string name;                        ///< for people; empty: host and process
    int threads = 0;                         ///< of a session; 0: one for each core
    int memory_mib = 2048;                   ///< for boxes, of all sessions
    int sessions = 1;                        ///< coordinators at once
    std::filesystem::path token_file;        ///< empty: TERRAVOX_FARM_TOKEN of the environment
    std::filesystem::path tls_ca, tls_cert, tls_key;  ///< PEM; all three, or none
    std::vector<remote::HttpOrigin> allow_origins;  ///< that coordinators may send it to for boxes,
                                                    ///< where they lead to public addresses
    std::vector<remote::HttpOrigin>
        allow_private_origins;  ///< and where they may lead to private and loopback ones
    std::optional<remote::HttpOrigin> server_origin;  ///< the one that gets the server's token
    std::filesystem::path server_token_file;          ///< set with server_origin alone
    std::optional<sockets::Address> metrics;  ///< of the page of metrics; its host is a number
    std::string metrics_names;                ///< host names of that page, separated by blanks
    double drain_s = 10;                      ///< for tiles under way when it is told to stop
    double idle_s = 0;         ///< it ends when no coordinator has come for so long; 0: never
    bool once = false;         ///< it ends with its first coordinator
    std::string log = "info";  ///< util::set_up_log
    bool log_json = false;
};

/// What the command line gives.
struct WorkerArguments {
    std::filesystem::path file;                               ///< empty: no file
    std::vector<std::pair<std::string, std::string>> fields;  ///< name and text, in the order given
};

/// Adds the flags to a command. `arguments` must outlive the parsing.
void add_worker_options(CLI::App& app, WorkerArguments& arguments);

/// The file, if any, with the flags over it; several --join replace those of the file. Paths in a
/// file are relative to the file. To be called again to reload. @throws UsageError for what cannot
/// be read, is unknown, out of range, or does not go together
[[nodiscard]] WorkerConfig load_worker_config(const WorkerArguments& arguments);

/// The token, read anew each time, or where the certificates are. @throws Error for a token that
/// cannot be had; UsageError where there is neither, or both
[[nodiscard]] net::Credentials credentials_of(const WorkerConfig& config);

/// The servers that it may ask, and the token of one of them. The environment has no say. @throws
/// Error for a token that cannot be had
[[nodiscard]] remote::HttpAccess http_access_of(const WorkerConfig& config);

/// How a reload differs from what runs, by names of fields in the order of WorkerConfig.
struct WorkerConfigChange {
    std::vector<std::string> now;      ///< hold from now on
    std::vector<std::string> restart;  ///< hold from the next start on
    friend bool operator==(const WorkerConfigChange&, const WorkerConfigChange&) = default;
};
[[nodiscard]] WorkerConfigChange difference(const WorkerConfig& running,
                                            const WorkerConfig& wanted);
/// What runs after a reload: the fields that may change at once are as wanted, the others as
/// before.
[[nodiscard]] WorkerConfig reloaded(const WorkerConfig& running, const WorkerConfig& wanted);

}  // namespace terravox::farm
