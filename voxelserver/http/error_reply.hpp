#pragma once

#include "voxelserver/http/message.hpp"

namespace terravox::http {

/// What a client learns of the exception that is being handled; the log gets the rest. To be called
/// in a catch block only.
///
/// - boxes::OverloadedError: 503, to be tried again after a second; not logged
/// - voxel::UnreachableError: 502, without the address of the other server
/// - everything else: 500; the text of a std::exception, without the folders of this machine
///
/// @throws only when there is no memory even for an error
[[nodiscard]] Response reply_to_current_exception(const Request& request);

}  // namespace terravox::http
