#pragma once

#include <string>
#include <string_view>

namespace terravox::gzip {

/// Packs bytes as a gzip file (RFC 1952), as small as it can: for what is written once and read
/// often. The same bytes give the same file, which names no time.
/// @throws std::bad_alloc
[[nodiscard]] std::string pack(std::string_view bytes);

}  // namespace terravox::gzip
