#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "common/util/error.hpp"
#include "voxelserver/worlds/remote/http_client.hpp"
#include "voxelserver/worlds/remote/retry.hpp"

namespace terravox::remote {

/// A failure of a try that a retry may resolve.
struct FailedTry : util::Error {
    FailedTry(Trouble what, const std::string& why,
              std::optional<std::chrono::seconds> later = std::nullopt)
        : util::Error(why), trouble(what), retry_after(later) {}
    Trouble trouble;
    std::optional<std::chrono::seconds> retry_after;  ///< as requested by the server
};

/// The trouble that a status stands for; nullopt: the status is final, no retry.
[[nodiscard]] std::optional<Trouble> trouble_of(long status) noexcept;

/// "HTTP status 500, reason", one line whatever the server sends.
[[nodiscard]] std::string problem_of(const HttpReply& reply);

/// A random number in [0, 1), for Retry. Affects only waits, never a picture. Thread-safe.
[[nodiscard]] double chance();

}  // namespace terravox::remote
