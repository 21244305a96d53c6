#pragma once

namespace terravox {

/// Threads do not survive a fork, and would be waited for: the library works in the process that
/// used it first, and in those that had not when they were forked.
/// @throws util::UsageError in a process that was forked after the library had been used
void check_process();

/// Whether this is the process that used the library first.
[[nodiscard]] bool is_first_process() noexcept;

}  // namespace terravox
