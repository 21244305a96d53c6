#include "tests/common/child_process.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <functional>

#include "common/util/error.hpp"
#include "tests/catch.hpp"

namespace terravox::test {

ChildEnd run_in_child(const std::function<void()>& work) {
    int ends[2];
    REQUIRE(::pipe(ends) == 0);
    const pid_t child = ::fork();
    if (child == 0) {
        ::dup2(ends[1], STDERR_FILENO);
        std::signal(SIGABRT, SIG_DFL);  // the test framework's handler stays in the parent
        util::end_with_a_line_on_uncaught_exceptions();
        work();
        ::_exit(0);
    }
    ::close(ends[1]);
    ChildEnd out;
    char part[512];
    for (ssize_t n = 0; (n = ::read(ends[0], part, sizeof part)) > 0;)
        out.error_output.append(part, static_cast<std::size_t>(n));
    ::close(ends[0]);
    ::waitpid(child, &out.status, 0);
    return out;
}

}  // namespace terravox::test
