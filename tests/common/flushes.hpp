#pragma once

namespace terravox::test {

/// How often this process has flushed a file to the disk so far, by fsync() or fdatasync(). What is
/// lost with the power cannot be tried, so tests count. For programs with flushes.cpp.
int flushes() noexcept;

}  // namespace terravox::test
