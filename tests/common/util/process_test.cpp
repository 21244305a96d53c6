#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <latch>
#include <mutex>
#include <new>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/process.hpp"
#include "tests/catch.hpp"
#include "tests/common/child_process.hpp"
#include "tests/common/content.hpp"
#include "tests/common/emulated.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::read_content;
using terravox::util::Error;
using terravox::util::find_program;
using terravox::util::Finished;
using terravox::util::Process;
using terravox::util::run_to_end;

namespace {

/// std::async and others would pass the exception on; a bare thread has no caller to pass it to.
template <class Thrown>
void throw_in_a_thread(const Thrown& thrown) {
    std::thread([&] { throw thrown; }).join();
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
/// Leaves the process without any memory to allocate.
void use_up_memory() {
    const rlimit none{1, 1};
    REQUIRE(::setrlimit(RLIMIT_AS, &none) == 0);
    // Volatile: else a compiler may leave out blocks that nothing reads, as GCC 16 does.
    static void* volatile last = nullptr;
    for (std::size_t bytes = std::size_t{1} << 20; bytes >= sizeof(void*); bytes /= 2) {
        while (void* const block = std::malloc(bytes)) {
            *static_cast<void**>(block) = last;
            last = block;
        }
    }
}
#endif

}  // namespace

TEST_CASE("a program's status and output are returned whole", "[common][util][process]") {
    const Finished done = run_to_end(
        {"bash", "-c",
         "head -c 300000 /dev/zero | tr '\\0' x; echo wrong >&2; echo more >&2; exit 3"});
    CHECK(done.status == 3);
    CHECK(done.out == std::string(300000, 'x'));
    CHECK(done.err == "wrong\nmore\n");
    CHECK(done.reason() == "wrong");
    CHECK(run_to_end({"bash", "-c", "kill -KILL $$"}).status == 128 + SIGKILL);
    CHECK(run_to_end({"pwd"}, "/").out == "/\n");
    CHECK(run_to_end({"cat"}).out.empty());  // nothing to read
    CHECK_THROWS_AS(run_to_end({"/nonexistent/program"}), Error);
    CHECK(find_program("sh") != "");
    CHECK(find_program("nonexistent program") == "");
}

TEST_CASE("a child is stopped, by force where need be, and does not outlive its owner",
          "[common][util][process]") {
    Process obeys({.command = {"sleep", "600"}});
    CHECK_FALSE(obeys.wait(std::chrono::milliseconds(1)).has_value());
    CHECK(obeys.stop() == 128 + SIGTERM);
    CHECK(obeys.stop() == 128 + SIGTERM);
    CHECK(obeys.wait(std::chrono::milliseconds(0)) == 128 + SIGTERM);
    // Once the marker is there it is deaf.
    const terravox::test::TemporaryFolder folder;
    const auto marker = folder.path() / "deaf";
    Process deaf({.command = {"bash", "-c", "trap '' TERM; > \"$1\"; while :; do sleep 0.05; done",
                              "bash", marker.string()}});
    for (int tries = 0; tries < 600 && !std::filesystem::exists(marker); ++tries)
        REQUIRE_FALSE(deaf.wait(std::chrono::milliseconds(100)).has_value());
    CHECK(deaf.stop(std::chrono::milliseconds(100)) == 128 + SIGKILL);
    Process ends({.command = {"bash", "-c", "exit 2"}});
    CHECK(ends.wait(std::chrono::seconds(30)) == 2);
    CHECK_THROWS_WITH(Process({.command = {"/nonexistent/program"}}),
                      "start /nonexistent/program: No such file or directory");
    CHECK_THROWS_WITH(Process({.command = {"nonexistent program"}}),
                      "start nonexistent program: No such file or directory");
    std::ofstream(folder.path() / "no program") << "x";
    std::filesystem::permissions(folder.path() / "no program", std::filesystem::perms::owner_all);
    CHECK_THROWS_AS(Process({.command = {(folder.path() / "no program").string()}}), Error);
}

TEST_CASE("a child's output goes to its log, from the start", "[common][util][process]") {
    const terravox::test::TemporaryFolder folder;
    const auto log = folder.path() / "log";
    std::ofstream(log) << "what was said before, at length";
    Process child({.command = {"bash", "-c", "echo out; echo err >&2"}, .log = log});
    CHECK(child.wait() == 0);
    CHECK(read_content(log) == "out\nerr\n");
    CHECK_THROWS_AS(Process({.command = {"true"}, .log = folder.path() / "none" / "log"}), Error);
    std::filesystem::create_symlink("log", folder.path() / "link");
    CHECK_THROWS_AS(Process({.command = {"true"}, .log = folder.path() / "link"}), Error);
}

TEST_CASE("a child has the variables, the folder and the signals that it is given",
          "[common][util][process]") {
    const terravox::test::TemporaryFolder folder;
    const auto log = folder.path() / "log";
    // What this process ignores or blocks stays so in the child, unless that is confined.
    const bool is_confined = GENERATE(false, true);
    sigset_t blocked;
    sigset_t before;
    ::sigemptyset(&blocked);
    ::sigaddset(&blocked, SIGUSR1);
    ::pthread_sigmask(SIG_BLOCK, &blocked, &before);
    Process::Start start{.command = {"bash", "-c", "pwd; echo $A$B; kill -USR1 $$; exit 4"},
                         .folder = "/",
                         .environment = {{"A=a", "PATH=/usr/bin:/bin"}},
                         .log = log};
    if (is_confined)
        start.confinement = {1000};
    Process child(start);
    ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
    CHECK(child.wait() == (is_confined ? 128 + SIGUSR1 : 4));
    CHECK(read_content(log) == "/\na\n");
}

TEST_CASE("a child that is let go is not ended", "[common][util][process]") {
    Process child({.command = {"sleep", "600"}, .may_outlive = true});
    const pid_t id = child.id();
    child.detach();
    CHECK(child.stop() == 0);
    CHECK(::kill(id, 0) == 0);
    ::kill(id, SIGKILL);
    ::waitpid(id, nullptr, 0);
}

TEST_CASE("an uncaught exception ends the program with one line and exit code 1",
          "[common][util]") {
    struct Case {
        const char* name;
        std::function<void()> work;
        const char* line;
    };
    const auto none_left = std::make_error_code(std::errc::resource_unavailable_try_again);
    const auto c = GENERATE_COPY(values<Case>({
        {"an error of ours", [] { throw_in_a_thread(util::Error("write x.png: disk full")); },
         "terravox: write x.png: disk full\n"},
        {"untrusted text", [] { throw_in_a_thread(util::Error("read 'a\n\x1b]0;b\xc3\xa9'")); },
         "terravox: read 'a?\?]0;b?\?'\n"},
        {"no memory", [] { throw_in_a_thread(std::bad_alloc()); },
         "terravox: out of memory; lower memory limits or a smaller task may help\n"},
        {"no thread", [=] { throw_in_a_thread(std::system_error(none_left)); },
         "terravox: the system gives no more threads or memory; fewer threads or higher limits of "
         "the system may help\n"},
        {"no exception at all",
         [] { std::vector<std::thread>(1).front() = std::thread([] { ::pause(); }); },
         "terravox: ended by an error inside the program that carries no message\n"},
        {"not of the standard library", [] { throw_in_a_thread(7); },
         "terravox: ended by an error inside the program that carries no message\n"},
    }));
    DYNAMIC_SECTION(c.name) {
        const test::ChildEnd end = test::run_in_child(c.work);
        CHECK(WIFEXITED(end.status));
        CHECK(WEXITSTATUS(end.status) == 1);
        CHECK(end.error_output == c.line);
    }
}

TEST_CASE("of errors in several threads at once only the first is printed, in one line",
          "[common][util]") {
    constexpr int kThreads = 8;
    for (int repeat = 0; repeat < 20; ++repeat) {
        const test::ChildEnd end = test::run_in_child([] {
            std::latch all(kThreads);
            std::vector<std::thread> threads;
            for (int i = 0; i < kThreads; ++i)
                threads.emplace_back([&] {
                    all.arrive_and_wait();
                    throw std::bad_alloc();
                });
            for (std::thread& t : threads)
                t.join();
        });
        CHECK(WIFEXITED(end.status));
        CHECK(WEXITSTATUS(end.status) == 1);
        REQUIRE(end.error_output ==
                "terravox: out of memory; lower memory limits or a smaller task may help\n");
    }
}

// Sanitizers need memory of their own to throw, and end the program without it.
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST_CASE("an exception leaves std::call_once when there is no memory left", "[common][util]") {
    if (test::emulated()) {
        WARN("not tried: the emulator would be without memory, too");
        return;
    }
    const test::ChildEnd end = test::run_in_child([] {
        use_up_memory();
        try {
            std::once_flag once;
            std::call_once(once, [] { throw std::bad_alloc(); });
        } catch (const std::bad_alloc&) {
            ::_exit(3);
        }
    });
    CHECK(WIFEXITED(end.status));
    CHECK(WEXITSTATUS(end.status) == 3);
    CHECK(end.error_output.empty());
}
#endif

TEST_CASE("messages of errors name a lack of memory and of threads in plain words",
          "[common][util]") {
    const auto none_left = std::make_error_code(std::errc::resource_unavailable_try_again);
    CHECK(util::to_message(std::make_exception_ptr(std::bad_alloc())).starts_with("out of memory"));
    CHECK(util::to_message(std::make_exception_ptr(std::system_error(none_left)))
              .starts_with("the system gives no more threads"));
    CHECK(util::to_message(std::make_exception_ptr(std::runtime_error("as it is"))) == "as it is");
    CHECK(util::to_message(std::make_exception_ptr(7)) == "an error that carries no message");
}
