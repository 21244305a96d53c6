#pragma once

#include "voxelserver/serve/http/service.hpp"

namespace terravox::http {

/// GET /v2/archive.tvx: the file of the box archive that is served, as it is now; 404 where the
/// world is no archive of this machine. Each request opens the file, so that a reply is of one
/// archive, however it is replaced meanwhile. Its tag is made of size and time: servers that share
/// an archive, or have copies with its time, agree about it.
[[nodiscard]] Response answer_archive(const Service& service, const RouteRequest& call);

}  // namespace terravox::http
