#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>

#include "common/voxel/archive/byte_source.hpp"
#include "voxelserver/make/worlds/kind/world_kind.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"
#include "voxelserver/make/worlds/remote/http_client.hpp"

namespace terravox::worlds {

/// Identifies a version of a file on a web server: the validators of its replies, and the file's
/// size.
/// Ref: RFC 9110, 8.8 and 13.1; RFC 9112.
struct FileState {
    static constexpr std::size_t kMaxEtag_bytes = 512;

    std::string etag;                    ///< with its quotes, "W/" before a weak one; empty: none
    std::string last_modified;           ///< as the server wrote it; empty: none
    std::optional<std::uint64_t> bytes;  ///< of the whole file

    /// The state that a reply reports. A header that is not of the form that RFC 9110 prescribes,
    /// or longer than kMaxEtag_bytes, counts as absent.
    [[nodiscard]] static FileState of(const remote::HttpReply& reply);

    /// The header that makes a server answer 412 instead of sending bytes of another version:
    /// If-Match with a strong entity tag, else If-Unmodified-Since; empty where there is neither.
    [[nodiscard]] std::string condition() const;
    /// Whether a later reply is of another version of the file: by size, and by the best validator
    /// that both have. With validators here and none there, the versions cannot be compared, and
    /// the later one counts as different; without any here, only the size counts.
    [[nodiscard]] bool differs_from(const FileState& later) const;
    /// One line that names this state; empty where nothing is known of it.
    [[nodiscard]] std::string text() const;
};

/// A box archive on any web server: its bytes are read with range requests, with retries
/// (retrying_client.hpp). Where the server sends an entity tag, a date or the size of the file, a
/// later reply of another version of the file throws ChangedError, and so do all reads after it.
/// @param url as HttpOrigin::of(): one with a query, such as a signed one, is refused
/// @param stop as ByteSource::stop, effective from opening on
/// @param access the origins that it may contact, and the token that it sends
/// @throws UsageError for a malformed address
[[nodiscard]] std::unique_ptr<voxel::archive::ByteSource> remote_archive(
    const std::string& url, std::chrono::milliseconds timeout, const std::stop_token& stop = {},
    const remote::HttpAccess& access = {});

/// Whether the path of an address ends like a box archive's.
[[nodiscard]] bool names_archive(const std::string& url);

/// A box archive of this machine.
extern const WorldKind kArchiveKind;

/// The http:// or https:// address of a box archive.
extern const WorldKind kRemoteArchiveKind;

}  // namespace terravox::worlds
