#pragma once

namespace terravox::util {

/// Raises this process's limit of open file descriptors to its maximum (the soft limit becomes the
/// hard one): a server needs some for each client.
void raise_open_file_limit() noexcept;

}  // namespace terravox::util
