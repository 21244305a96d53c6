#pragma once

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace terravox::util {

/// Gives pages that the allocator keeps for later back to the system, where it can: after much of
/// differing sizes was freed, it may hold as much again as is in use. Takes milliseconds.
inline void give_back_free_memory() noexcept {
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

}  // namespace terravox::util
