#include "raytracer/library/process_check.hpp"

#include <unistd.h>

#include <atomic>

#include "common/util/error.hpp"

namespace terravox {
namespace {

std::atomic<pid_t> s_first{0};

}  // namespace

bool is_first_process() noexcept {
    pid_t first = 0;
    const pid_t here = ::getpid();
    return s_first.compare_exchange_strong(first, here) || first == here;
}

void check_process() {
    if (!is_first_process())
        throw util::UsageError(
            "use Terravox: this process was forked by one that had used it, and has none of its "
            "threads; allowed: processes that are started anew (in Python: multiprocessing's "
            "methods spawn and forkserver)");
}

}  // namespace terravox
