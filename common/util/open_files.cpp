#include "common/util/open_files.hpp"

#include <sys/resource.h>

namespace terravox::util {

void allow_many_open_files() noexcept {
    rlimit limit{};
    if (::getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == limit.rlim_max)
        return;
    limit.rlim_cur = limit.rlim_max;
    (void)::setrlimit(RLIMIT_NOFILE,
                      &limit);  // else it stays as it is, and the limits on links with it
}

}  // namespace terravox::util
