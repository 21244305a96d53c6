#pragma once

#include <cstddef>
#include <span>

namespace terravox::util {

/// Writes all bytes at the position of an open file, in as many calls as that takes.
/// @return 0, or errno of the call that failed: then some of the bytes may be written
[[nodiscard]] int write_all(int fd, std::span<const std::byte> bytes) noexcept;

}  // namespace terravox::util
