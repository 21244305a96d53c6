#include "common/util/open_files.hpp"

#include <sys/resource.h>

namespace terravox::util {

void raise_open_file_limit() noexcept {
    rlimit limit{};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == limit.rlim_max)
        return;
    limit.rlim_cur = limit.rlim_max;
    // On failure the limit is unchanged, and so are the limits on connections that depend on it.
    (void)::setrlimit(RLIMIT_NOFILE, &limit);
}

}  // namespace terravox::util
