#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "common/util/error.hpp"
#include "voxelserver/make/worlds/remote/http_client.hpp"
#include "voxelserver/make/worlds/remote/retry.hpp"

namespace terravox::remote {

/// A failure of a try that a retry may resolve.
struct FailedTry : util::Error {
    FailedTry(FailureKind failure, const std::string& why,
              std::optional<std::chrono::seconds> later = std::nullopt)
        : util::Error(why), kind(failure), retry_after(later) {}
    FailureKind kind;
    std::optional<std::chrono::seconds> retry_after;  ///< as requested by the server
};

/// The kind of failure that a status stands for; nullopt: the status is final, no retry.
[[nodiscard]] std::optional<FailureKind> failure_kind_of(long status) noexcept;

/// "HTTP status 500, reason", one line whatever the server sends.
[[nodiscard]] std::string problem_of(const HttpReply& reply);

/// A random number in [0, 1), for Retry. Affects only waits, never a picture. Thread-safe.
[[nodiscard]] double chance();

}  // namespace terravox::remote
