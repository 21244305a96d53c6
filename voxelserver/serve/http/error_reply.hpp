#pragma once

#include "voxelserver/serve/http/message.hpp"

namespace terravox::http {

/// Converts the exception that is being handled to a reply; details that clients must not see are
/// only logged. Must be called in a catch block only.
///
/// - boxes::OverloadedError: 503, to be retried after a second; not logged
/// - voxel::UnreachableError: 502, without the address of the other server
/// - everything else: 500; the text of a std::exception, without the folders of this machine
///
/// @throws only when there is not enough memory for an error reply
[[nodiscard]] Response reply_to_current_exception(const Request& request);

}  // namespace terravox::http
