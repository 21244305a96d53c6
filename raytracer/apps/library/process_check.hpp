#pragma once

namespace terravox {

/// Threads do not survive a fork, and would be waited for: the library works in the process in
/// which it first had threads, and in those that were forked before that.
/// @throws util::UsageError in a process that was forked later
void check_process();

/// To be called before threads are made.
/// @throws as check_process()
void note_process();

/// Whether threads of the library that were made are in this process.
[[nodiscard]] bool has_threads_here() noexcept;

}  // namespace terravox
