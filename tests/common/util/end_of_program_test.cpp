#include "common/util/error.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <functional>
#include <latch>
#include <mutex>
#include <new>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <vector>

#include "tests/catch.hpp"
#include "tests/common/child_process.hpp"
#include "tests/common/emulated.hpp"

using namespace terravox;

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
