#include "common/util/folders.hpp"

#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>
#include <fstream>
#include <utility>

#include "tests/catch.hpp"

namespace util = terravox::util;

TEST_CASE("a temporary folder is this user's alone, and goes with its object", "[util]") {
    std::filesystem::path path;
    {
        util::TemporaryFolder first = util::TemporaryFolder::make("test");
        path = first.path();
        struct stat status{};
        REQUIRE(::stat(path.c_str(), &status) == 0);
        CHECK((status.st_mode & 0777) == 0700);
        std::ofstream(path / "file") << "text";
        const util::TemporaryFolder second = std::move(first);
        CHECK(second.path() == path);
        CHECK(std::filesystem::exists(path / "file"));
        CHECK(util::TemporaryFolder::make("test").path() != path);
    }
    CHECK(!std::filesystem::exists(path));
}

TEST_CASE("a temporary folder can be removed at once, and an empty one is none", "[util]") {
    util::TemporaryFolder folder = util::TemporaryFolder::make("test");
    const std::filesystem::path path = folder.path();
    folder.remove();
    CHECK(!std::filesystem::exists(path));
    folder.remove();
    CHECK(util::TemporaryFolder().path().empty());
}

TEST_CASE("the folder of a process that was killed goes with the next one, and no other",
          "[util]") {
    const util::TemporaryFolder living = util::TemporaryFolder::make("test");
    // Shared with the child.
    int ends[2];
    REQUIRE(::pipe(ends) == 0);
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {
        const util::TemporaryFolder left = util::TemporaryFolder::make("test");
        std::ofstream(left.path() / "file") << "text";
        const std::string name = left.path().string();
        const bool told = ::write(ends[1], name.c_str(), name.size()) > 0;
        ::_exit(told ? 0 : 1);  // without destructors
    }
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    REQUIRE(status == 0);
    char name[4096] = {};
    REQUIRE(::read(ends[0], name, sizeof name - 1) > 0);
    ::close(ends[0]);
    ::close(ends[1]);
    CHECK(std::filesystem::exists(living.path()));
    // Another process of these tests may have removed it already.
    const util::TemporaryFolder next = util::TemporaryFolder::make("test");
    CHECK_FALSE(std::filesystem::exists(name));
    CHECK(std::filesystem::exists(living.path()));
    CHECK(std::filesystem::exists(next.path()));
}

TEST_CASE("folders of other names are left alone", "[util]") {
    const util::TemporaryFolder all = util::TemporaryFolder::make("test");
    const std::filesystem::path other =
        all.path().parent_path() / "terravox-run-with-a-longer-name";
    std::filesystem::create_directory(other);
    const util::TemporaryFolder next = util::TemporaryFolder::make("test");
    CHECK(std::filesystem::exists(other));
    std::filesystem::remove(other);
}
