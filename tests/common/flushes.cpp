#include "tests/common/flushes.hpp"

#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>

namespace {

std::atomic<int> g_flushes{0};

int count_and_flush(long call, int fd) noexcept {
    ++g_flushes;
    return static_cast<int>(::syscall(call, fd));
}

}  // namespace

// A program's own functions come before those of the C library.
extern "C" int fsync(int fd) {
    return count_and_flush(SYS_fsync, fd);
}

extern "C" int fdatasync(int fd) {
    return count_and_flush(SYS_fdatasync, fd);
}

namespace terravox::test {

int flushes() noexcept {
    return g_flushes;
}

}  // namespace terravox::test
