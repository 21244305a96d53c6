#include "common/util/files.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

namespace terravox::util {

using test::contains;

TEST_CASE("a file is locked once at a time, also within a process", "[util][lock]") {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "lock";
    CHECK_FALSE(FileLock::is_taken(file));
    CHECK_FALSE(std::filesystem::exists(file));
    {
        const auto lock = FileLock::try_take(file);
        REQUIRE(lock);
        CHECK(FileLock::is_taken(file));
        CHECK_FALSE(FileLock::try_take(file));
        CHECK(FileLock::is_taken(file));
        CHECK_THAT(FileLock::holder(file), contains("process " + std::to_string(::getpid())));
    }
    CHECK_FALSE(FileLock::is_taken(file));
    CHECK(FileLock::try_take(file));
}

TEST_CASE("a lock moves with its object", "[util][lock]") {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "lock";
    auto first = FileLock::try_take(file);
    REQUIRE(first);
    std::optional<FileLock> second(std::move(*first));
    first.reset();
    CHECK(FileLock::is_taken(file));
    second.reset();
    CHECK_FALSE(FileLock::is_taken(file));
}

TEST_CASE("a lock ends with its process, however that ends", "[util][lock]") {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "lock";
    std::array<int, 2> pipe{};
    REQUIRE(::pipe(pipe.data()) == 0);
    const pid_t child = ::fork();
    if (child == 0) {
        const auto lock = FileLock::try_take(file);
        const char said = lock ? 'y' : 'n';
        [[maybe_unused]] const auto written = ::write(pipe[1], &said, 1);
        while (true)
            ::pause();
    }
    REQUIRE(child > 0);
    char said = 0;
    REQUIRE(::read(pipe[0], &said, 1) == 1);
    CHECK(said == 'y');
    CHECK(FileLock::is_taken(file));
    CHECK_FALSE(FileLock::try_take(file));
    CHECK_THAT(FileLock::holder(file), contains(std::to_string(child)));
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    ::close(pipe[0]);
    ::close(pipe[1]);
    CHECK_FALSE(FileLock::is_taken(file));
    CHECK(FileLock::try_take(file));
}

TEST_CASE("one at a time has the lock, also where holders remove its file", "[util][lock]") {
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "lock";
    constexpr int kTimes = 300;
    std::atomic<int> holders{0};
    std::atomic<int> clashes{0};
    const auto take_often = [&] {
        for (int taken = 0; taken < kTimes;) {
            const auto lock = FileLock::try_take(file);
            if (!lock)
                continue;
            clashes += holders++ > 0 ? 1 : 0;
            ++taken;
            --holders;
            std::filesystem::remove(file);  // from here on another may have it
        }
    };
    {
        const std::jthread one(take_often);
        const std::jthread other(take_often);
    }
    CHECK(clashes == 0);
}

TEST_CASE("what cannot be locked is an error with its name", "[util][lock]") {
    const test::TemporaryFolder folder;
    CHECK_THROWS_AS(FileLock::try_take(folder.path() / "none" / "lock"), Error);
    CHECK(FileLock::holder(folder.path() / "none") == "another process");
}

TEST_CASE("a link at the name of a lock is refused, and what it leads to is not written",
          "[util][lock]") {
    const test::TemporaryFolder folder;
    const auto precious = folder.path() / "precious";
    std::ofstream(precious) << "as it was";
    std::filesystem::create_symlink(precious, folder.path() / "run.lock");
    CHECK_THROWS_WITH(FileLock::try_take(folder.path() / "run.lock"),
                      test::contains("run.lock is a symbolic link"));
    CHECK(std::filesystem::file_size(precious) == 9);
}

}  // namespace terravox::util
