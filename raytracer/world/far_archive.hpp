#pragma once

#include <chrono>
#include <memory>
#include <stop_token>
#include <string>

#include "common/voxel/archive/byte_source.hpp"

namespace terravox {

/// A box archive that any web server gives out: its bytes are asked for by ranges, with patience (patient_client.hpp).
/// @param url http(s)://host[:port]/path.tvx
/// @param stop as ByteSource::stop, from opening on
/// @throws UsageError for a malformed address
[[nodiscard]] std::unique_ptr<voxel::archive::ByteSource> far_archive(const std::string& url, std::chrono::milliseconds patience, const std::stop_token& stop = {});

/// Whether the path of an address ends like a box archive's.
[[nodiscard]] bool names_archive(const std::string& url);

}  // namespace terravox
