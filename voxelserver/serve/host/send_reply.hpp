#pragma once

#include <cstdint>
#include <string>

#include "voxelserver/serve/host/message.hpp"

namespace terravox::http {

/// Whether the client wants the connection to stay open for another request: the decision that
/// CivetWeb makes from the same header, needed earlier for the reply's header.
[[nodiscard]] bool wants_keep_alive(const Request& request);

struct SentReply {
    std::uint64_t body_bytes = 0;
    bool keep_alive = false;  ///< false also when not all of it was sent
};
/// Sends a reply. Does not throw for an error of a file or a stream, which can no longer be
/// reported: the connection ends, and the client sees that bytes are missing.
/// @param write sends bytes as they are
/// @param buffer memory for heads and parts of bodies: allocating it for each reply would cost page
/// faults
/// @param head_only for HEAD: the length of the body is sent, the body is not
/// @param keep_alive whether the connection is to stay open
/// @param http_1_0  has no chunked encoding: there, closing the connection ends a stream
SentReply send_reply(const Write& write, std::string& buffer, const Response& reply, bool head_only,
                     bool keep_alive, bool http_1_0);

}  // namespace terravox::http
