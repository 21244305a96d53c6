#pragma once

#include <chrono>
#include <memory>
#include <stop_token>
#include <string>

#include "common/voxel/archive/byte_source.hpp"
#include "voxelserver/worlds/remote/http_access.hpp"

namespace terravox::worlds {

/// A box archive that any web server gives out: its bytes are asked for by ranges, with retries
/// (retrying_client.hpp). Where the server tells an entity tag, a date or the size of the file, a
/// later reply of another file is a ChangedError, and so is all that is read then.
/// @param url as HttpOrigin::of(): one with a query, such as a signed one, is refused
/// @param stop as ByteSource::stop, from opening on
/// @param access whom it may ask, and what it shows there
/// @throws UsageError for a malformed address
[[nodiscard]] std::unique_ptr<voxel::archive::ByteSource> remote_archive(
    const std::string& url, std::chrono::milliseconds timeout, const std::stop_token& stop = {},
    const remote::HttpAccess& access = {});

/// Whether the path of an address ends like a box archive's.
[[nodiscard]] bool names_archive(const std::string& url);

}  // namespace terravox::worlds
