#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/files.hpp"
#include "common/util/folders.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using terravox::test::contains;
using terravox::util::expand_folders;
using terravox::util::UsageError;
namespace util = terravox::util;

TEST_CASE("folders become their files, sorted, by ending in any case", "[common][util][files]") {
    const test::TemporaryFolder folder;
    for (const char* name : {"b.laz", "a.LAZ", "c.las", "notes.txt", ".hidden.laz", "other.zip"})
        std::ofstream(folder.path() / name) << "x";
    using Paths = std::vector<std::filesystem::path>;
    CHECK(expand_folders({folder.path()}, {".laz", ".las"}, "LiDAR data") ==
          Paths{folder.path() / "a.LAZ", folder.path() / "b.laz", folder.path() / "c.las"});
    CHECK(expand_folders({folder.path() / "notes.txt"}, {".laz"}, "LiDAR data") ==
          Paths{folder.path() / "notes.txt"});
    CHECK(expand_folders({folder.path() / "b.laz", folder.path()}, {".laz"}, "LiDAR data") ==
          Paths{folder.path() / "b.laz", folder.path() / "a.LAZ"});
    CHECK(expand_folders({}, {".laz"}, "LiDAR data").empty());
}

TEST_CASE("a file named twice is one file, whatever its names", "[common][util][files]") {
    namespace fs = std::filesystem;
    const test::TemporaryFolder folder;
    const fs::path& at = folder.path();
    fs::create_directory(at / "inside");
    std::ofstream(at / "b.laz") << "x";
    std::ofstream(at / "twin.laz") << "x";  // as long, but another file
    fs::last_write_time(at / "twin.laz", fs::last_write_time(at / "b.laz"));
    fs::create_symlink(at / "b.laz", at / "inside" / "soft.laz");
    fs::create_directory_symlink(at, at / "inside" / "up");
    fs::create_hard_link(at / "b.laz", at / "inside" / "hard.laz");
    struct Case {
        const char *name, *other, *kept;
    };
    const auto c = GENERATE(values<Case>({
        {"itself", "b.laz", "b.laz"},
        {"a dot in the path", "./b.laz", "./b.laz"},
        {"up and down", "inside/../b.laz", "b.laz"},
        {"a link", "inside/soft.laz", "b.laz"},
        {"a link to the folder", "inside/up/b.laz", "b.laz"},
        {"a second name", "inside/hard.laz", "b.laz"},
    }));
    DYNAMIC_SECTION(c.name) {
        using Paths = std::vector<fs::path>;
        CHECK(expand_folders({at / "b.laz", at / c.other, at / "twin.laz"}, {".laz"},
                             "LiDAR data") == Paths{at / c.kept, at / "twin.laz"});
        CHECK(expand_folders({at / c.other, at / "twin.laz", at / "b.laz"}, {".laz"},
                             "LiDAR data") == Paths{at / c.kept, at / "twin.laz"});
    }
    CHECK(expand_folders({at, at / "inside"}, {".laz"}, "LiDAR data").size() == 2);
}

TEST_CASE("a path without data is a mistake that is named", "[common][util][files]") {
    const test::TemporaryFolder folder;
    std::ofstream(folder.path() / "notes.txt") << "x";
    CHECK_THROWS_AS(expand_folders({folder.path()}, {".laz", ".las"}, "LiDAR data"), UsageError);
    CHECK_THROWS_WITH(
        expand_folders({folder.path()}, {".laz", ".las"}, "LiDAR data"),
        contains("LiDAR data") && contains(folder.path().string()) && contains(".laz .las"));
    CHECK_THROWS_AS(expand_folders({folder.path() / "absent"}, {".laz"}, "LiDAR data"), UsageError);
    CHECK_THROWS_WITH(expand_folders({folder.path() / "absent"}, {".laz"}, "LiDAR data"),
                      contains("absent: no such file or folder"));
}

TEST_CASE("a file that is written in its place is a plain one, and never behind a link",
          "[common][util][files]") {
    namespace fs = std::filesystem;
    const test::TemporaryFolder folder;
    const auto open = [&](const char* name, int flags) {
        return terravox::util::open_to_write(folder.path() / name, flags, 0644, "keep the notes");
    };
    const fs::path precious = folder.path() / "precious";
    std::ofstream(precious) << "as it was";
    fs::create_symlink("precious", folder.path() / "link");
    fs::create_symlink("nothing", folder.path() / "link to nothing");
    fs::create_directory(folder.path() / "folder");
    REQUIRE(::mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);
    for (const char* const name : {"link", "link to nothing"}) {
        CAPTURE(name);
        CHECK_THROWS_WITH(open(name, O_WRONLY | O_CREAT | O_TRUNC),
                          contains("keep the notes: ") &&
                              contains((folder.path() / name).string() + " is a symbolic link"));
    }
    CHECK(fs::file_size(precious) == 9);
    CHECK_FALSE(fs::exists(folder.path() / "nothing"));
    CHECK_THROWS_WITH(open("pipe", O_RDWR | O_CREAT), contains("pipe is not a plain file"));
    CHECK_THROWS_WITH(open("pipe", O_WRONLY), contains("keep the notes: No such device"));
    CHECK_THROWS_WITH(open("folder", O_RDWR | O_CREAT), contains("keep the notes: Is a directory"));
    for (const char* const name : {"precious", "new"}) {
        const int fd = open(name, O_WRONLY | O_CREAT | O_TRUNC);
        CHECK(terravox::util::is_named(fd, folder.path() / name));
        ::close(fd);
        CHECK(fs::file_size(folder.path() / name) == 0);
    }
}

TEST_CASE("a text is read whole, up to its limit, and of plain files only",
          "[common][util][files]") {
    using terravox::util::read_text;
    using terravox::util::try_read_text;
    const test::TemporaryFolder folder;
    const auto file = folder.path() / "a";
    const std::string text = std::string(200'000, 'x') + std::string("\0\r\n\xff", 4);
    std::ofstream(file, std::ios::binary) << text;
    CHECK(read_text(file, text.size(), "read a") == text);
    CHECK(try_read_text(file, text.size()) == text);
    CHECK_THROWS_WITH(read_text(file, text.size() - 1, "read a"),
                      "read a: more than 200003 bytes; allowed: up to that");
    CHECK_THROWS_WITH(read_text("/dev/zero", 1, "read it"), "read it: not a plain file");
    CHECK_THROWS_WITH(read_text(folder.path() / "none", 1, "read it"), "read it: no such file");
    CHECK_THROWS_WITH(read_text(file / "none", 1, "read it"), "read it: no such file");
    CHECK(try_read_text(file, text.size() - 1) == std::nullopt);
    CHECK(try_read_text(folder.path(), 1000) == std::nullopt);
    // A hole of a tebibyte is not read.
    std::filesystem::resize_file(file, std::uintmax_t{1} << 40);
    CHECK_THROWS_WITH(read_text(file, std::size_t{1} << 20, "read a"),
                      "read a: more than 1 MiB; allowed: up to that");
    CHECK(terravox::util::read_start(file, 3) == "xxx");
    CHECK(terravox::util::read_start(folder.path() / "none", 3).empty());
    CHECK_FALSE(read_text("/proc/self/status", std::size_t{1} << 20, "read it").empty());
}

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

TEST_CASE("the configuration is found next to the sources, or where TERRAVOX_CONFIG says",
          "[common][util][config_dir]") {
    const char* before = std::getenv("TERRAVOX_CONFIG");
    const std::string kept = before != nullptr ? before : "";
    const std::filesystem::path shipped = std::filesystem::path(TERRAVOX_SOURCE_DIR) / "config";

    ::unsetenv("TERRAVOX_CONFIG");
    CHECK(std::filesystem::equivalent(util::config_dir(), shipped));
    ::setenv("TERRAVOX_CONFIG", shipped.c_str(), 1);
    CHECK(util::config_dir() == shipped);
    const test::TemporaryFolder empty;
    ::setenv("TERRAVOX_CONFIG", empty.path().c_str(), 1);
    CHECK_THROWS_AS(util::config_dir(), util::UsageError);
    CHECK_THROWS_WITH(util::config_dir(), test::contains(empty.path().string()));

    if (before != nullptr)
        ::setenv("TERRAVOX_CONFIG", kept.c_str(), 1);
    else
        ::unsetenv("TERRAVOX_CONFIG");
}
