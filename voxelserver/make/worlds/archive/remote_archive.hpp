#pragma once

#include <chrono>
#include <memory>
#include <stop_token>
#include <string>

#include "common/voxel/archive/byte_source.hpp"
#include "voxelserver/make/worlds/remote/http_access.hpp"

namespace terravox::worlds {

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

}  // namespace terravox::worlds
