#pragma once

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace terravox::util {

/// Returns free pages that the allocator retains to the system, where possible: after many blocks
/// of different sizes were freed, it may retain as much again as is in use. Takes milliseconds.
inline void trim_heap() noexcept {
#ifdef __GLIBC__
    malloc_trim(0);
#endif
}

}  // namespace terravox::util
