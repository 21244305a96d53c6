#include "raytracer/apps/library/process_check.hpp"

#include <unistd.h>

#include <atomic>

#include "common/util/error.hpp"

namespace terravox {
namespace {

std::atomic<pid_t> s_first{0};

}  // namespace

bool has_threads_here() noexcept {
    return s_first == ::getpid();
}

void note_process() {
    pid_t none = 0;
    s_first.compare_exchange_strong(none, ::getpid());
    check_process();
}

void check_process() {
    if (s_first != 0 && !has_threads_here())
        throw util::UsageError(
            "use Terravox: this process was forked by one that had used it, and has none of its "
            "threads; allowed: processes that are started anew (in Python: multiprocessing's "
            "methods spawn and forkserver)");
}

}  // namespace terravox
