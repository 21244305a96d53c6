#include "tests/bench/children.hpp"

#include <fstream>

#include "common/util/process_memory.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using terravox::bench::ChildRunner;
using terravox::bench::last_line;

TEST_CASE("a program's end and output are told", "[bench][children]") {
    struct Case {
        const char* name;
        std::vector<std::string> command;
        int exit_code;
        const char* said;
    };
    const auto c = GENERATE(values<Case>({
        {"success", {"sh", "-c", "echo one; echo two"}, 0, "two"},
        {"failure, on the error channel", {"sh", "-c", "echo bad >&2; exit 3"}, 3, "bad"},
        {"arguments with spaces and empty ones",
         {"sh", "-c", "echo \"$1|$2\"", "sh", "", "a b"},
         0,
         "|a b"},
        {"a signal", {"sh", "-c", "kill -9 $$"}, 137, ""},
        {"no such program",
         {"/nowhere/at-all"},
         127,
         "start /nowhere/at-all: No such file or directory"},
    }));
    const terravox::test::TemporaryFolder folder;
    ChildRunner runner;
    DYNAMIC_SECTION(c.name) {
        const auto outcome = runner.run(c.command, folder.path() / "said.txt");
        CHECK(outcome.exit_code == c.exit_code);
        CHECK(last_line(folder.path() / "said.txt") == c.said);
        CHECK(outcome.wall_s >= 0);
    }
}

TEST_CASE("a small program's peak memory is its own, however much this process holds",
          "[bench][children]") {
    constexpr std::size_t kLarge_bytes = std::size_t{256} << 20;
    const terravox::test::TemporaryFolder folder;
    ChildRunner runner;
    const std::vector<char> large(kLarge_bytes, 1);
    const auto outcome = runner.run({"sh", "-c", "exit 0"}, folder.path() / "said.txt");
    CHECK(outcome.exit_code == 0);
    CHECK(outcome.peak_kib > 0);
    // Compared with this process, since sanitizers add memory of their own to every program.
    const std::uint64_t own_bytes = terravox::util::resident_bytes();
    CHECK(static_cast<std::uint64_t>(outcome.peak_kib) * 1024 + large.size() / 2 < own_bytes);
}
