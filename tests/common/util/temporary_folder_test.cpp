#include "common/util/temporary_folder.hpp"

#include <sys/stat.h>

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
