#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "voxelserver/serve/http/message.hpp"

struct mg_connection;
struct mg_request_info;

namespace terravox::http {

/// What a client has asked, in our own form. The views live as long as `info`.
[[nodiscard]] Request make_request(const mg_request_info& info);

/// Whether the connection stays open for another request: the decision that CivetWeb makes from the
/// same header, needed earlier for the reply's header.
/// @param http_version  as CivetWeb has it; may be null
[[nodiscard]] bool wants_keep_alive(const Request& request, const char* http_version);

/// Reads a body of a known length.
/// @return false when it was not received in time, or is incomplete
[[nodiscard]] bool read_body(mg_connection* connection, std::uint64_t bytes,
                             std::chrono::milliseconds timeout, std::string& body);

/// Sends a reply. One that is sent as a whole is put together in the thread's buffer: a
/// std::string that CivetWeb's thread pointer leads to.
/// @param http_1_0  has no chunked encoding: there, closing the connection ends a stream
/// @return number of bytes of the body that were sent
std::uint64_t send_response(mg_connection* connection, const Response& response, bool keep_alive,
                            bool http_1_0 = false);

/// Sends a status 500 and closes the connection; needs no memory.
void send_last_resort(mg_connection* connection) noexcept;

}  // namespace terravox::http
