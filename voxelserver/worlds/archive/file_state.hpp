#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "voxelserver/worlds/remote/http_client.hpp"

namespace terravox::worlds {

/// What tells one state of a web server's file from the next: the validators of its replies, and
/// the file's size. Ref: RFC 9110, 8.8 and 13.1; RFC 9112.
struct FileState {
    static constexpr std::size_t kMaxEtag_bytes = 512;

    std::string etag;                    ///< with its quotes, "W/" before a weak one; empty: none
    std::string last_modified;           ///< as the server wrote it; empty: none
    std::optional<std::uint64_t> bytes;  ///< of the whole file

    /// As a reply tells it. What is not of the form that RFC 9110 gives to it, or longer than
    /// kMaxEtag_bytes, counts as not told.
    [[nodiscard]] static FileState of(const remote::HttpReply& reply);

    /// The header with which a server answers 412 instead of bytes of another state: If-Match with
    /// a strong entity tag, else If-Unmodified-Since; empty where there is neither.
    [[nodiscard]] std::string condition() const;
    /// Whether a later reply is of another file: by size, and by the best validator that both told.
    /// With validators here, and none of them there, it cannot be told to be the same, and counts
    /// as another; without any here, size alone counts.
    [[nodiscard]] bool differs_from(const FileState& later) const;
    /// One line that names this state; empty where nothing is known of it.
    [[nodiscard]] std::string text() const;
};

}  // namespace terravox::worlds
