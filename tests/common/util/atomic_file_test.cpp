#include "common/util/atomic_file.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <fstream>
#include <set>
#include <string>
#include <utility>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/flushes.hpp"
#include "tests/common/full_disk.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using namespace terravox::util;
using terravox::test::contains;
using terravox::test::read_content;
using terravox::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

std::size_t entries_in(const fs::path& folder) {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

std::span<const std::byte> to_bytes(std::string_view text) {
    return std::as_bytes(std::span(text));
}

}  // namespace

TEST_CASE("a file appears under its name only when it is committed",
          "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    const auto target = folder.path() / "picture.png";
    {
        AtomicFile file(target);
        std::ofstream(file.temporary_path()) << "whole";
        CHECK_FALSE(fs::exists(target));
        CHECK(file.target() == target);
        file.commit();
        CHECK(read_content(target) == "whole");
    }
    CHECK(read_content(target) == "whole");
    CHECK(entries_in(folder.path()) == 1);
}

TEST_CASE("bytes are appended until the file is committed", "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    const auto target = folder.path() / "archive.tvx";
    AtomicFile file(target);
    file.append(to_bytes("one "));
    file.append({});
    file.append(to_bytes("two "));
    file.close();
    file.close();
    file.append(to_bytes("three"));
    CHECK_FALSE(fs::exists(target));
    file.commit();
    CHECK(read_content(target) == "one two three");
    CHECK(entries_in(folder.path()) == 1);
}

TEST_CASE("a file is on the disk before it has its name, unless it can be made again",
          "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    const auto count_flushes = [&](const char* name, const auto& commit) {
        AtomicFile file(folder.path() / name);
        file.append(to_bytes("whole"));
        const int before = terravox::test::flushes();
        commit(file);
        return terravox::test::flushes() - before;
    };
    CHECK(count_flushes("kept", [](AtomicFile& f) { f.commit(); }) == 1);
    CHECK(count_flushes("new", [](AtomicFile& f) { f.commit_as_new(); }) == 1);
    CHECK(count_flushes("cached", [](AtomicFile& f) { f.commit(AtomicFile::Flush::kNo); }) == 0);
}

TEST_CASE("a file that is committed as new replaces none", "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    const auto target = folder.path() / "parts.tiles";
    {
        AtomicFile file(target);
        file.append(to_bytes("first"));
        file.commit_as_new();
    }
    CHECK(read_content(target) == "first");
    {
        AtomicFile file(target);
        file.append(to_bytes("second"));
        CHECK_THROWS_AS(file.commit_as_new(), UsageError);
    }
    CHECK(read_content(target) == "first");
    CHECK(entries_in(folder.path()) == 1);
}

TEST_CASE("what lies at the name of a temporary file is not written to",
          "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    const auto target = folder.path() / "picture.png";
    const auto precious = folder.path() / "precious";
    std::ofstream(precious) << "as it was";
    {
        AtomicFile file(target);
        fs::create_symlink(precious, file.temporary_path());
        CHECK_THROWS_WITH(file.append(to_bytes("new")),
                          contains("write " + target.string()) &&
                              contains(file.temporary_path().string() + " is a symbolic link"));
    }
    {
        AtomicFile file(target);
        fs::create_hard_link(precious, file.temporary_path());
        CHECK_THROWS_WITH(file.append(to_bytes("new")), contains("File exists"));
    }
    CHECK(read_content(precious) == "as it was");
    CHECK(entries_in(folder.path()) == 1);
}

TEST_CASE("the name of a temporary file does not tell that of the next",
          "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    std::set<std::string> beginnings;
    for (int i = 0; i < 20; ++i) {
        const AtomicFile file(folder.path() / "a");
        std::string name = file.temporary_path().filename().string();
        REQUIRE(name.size() > 8);
        name.resize(name.size() - 8);
        beginnings.insert(name);
    }
    CHECK(beginnings.size() == 20);
}

TEST_CASE("an append that fails names the target and the reason", "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    const auto target = folder.path() / "archive.tvx";
    {
        AtomicFile file(target);
        file.append(to_bytes("one"));
        const terravox::test::FullDisk full(3);
        CHECK_THROWS_WITH(file.append(to_bytes("two")),
                          contains(target.string()) && contains("File too large"));
    }
    CHECK(entries_in(folder.path()) == 0);
}

TEST_CASE("without a commit nothing stays behind, and an older file keeps its content",
          "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    const auto target = folder.path() / "picture.png";
    std::ofstream(target) << "older";
    {
        const AtomicFile file(target);
        std::ofstream(file.temporary_path()) << "half";
        CHECK(entries_in(folder.path()) == 2);
    }
    CHECK(read_content(target) == "older");
    CHECK(entries_in(folder.path()) == 1);
}

TEST_CASE("the temporary file keeps folder and extension, and is one of its kind",
          "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    const AtomicFile a(folder.path() / "a.exr"), b(folder.path() / "a.exr");
    CHECK(a.temporary_path().extension() == ".exr");
    CHECK(a.temporary_path().parent_path() == folder.path());
    CHECK(a.temporary_path() != b.temporary_path());
    CHECK(a.temporary_path() != a.target());
    // .gitignore and clean-up know it by this part of its name.
    CHECK_THAT(a.temporary_path().filename().string(), contains(".part-"));
}

TEST_CASE("whole files are written, empty and large, over older ones",
          "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    const auto target = folder.path() / "deep" / "er" / "box.bin";  // the folders are made
    for (const std::size_t size :
         {std::size_t{0}, std::size_t{1}, std::size_t{5'000'000}, std::size_t{3}}) {
        std::string content(size, 'x');
        for (std::size_t i = 0; i < size; i += 997)
            content[i] = static_cast<char>('a' + i % 26);
        write_file_atomically(target, to_bytes(content));
        INFO(size << " bytes");
        CHECK(read_content(target) == content);
        CHECK(entries_in(target.parent_path()) == 1);
    }
}

TEST_CASE("a place that cannot be written to is named before any work is done",
          "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    std::ofstream(folder.path() / "file") << "a file";
    fs::create_directory(folder.path() / "taken");
    fs::create_symlink("loop", folder.path() / "loop");
    fs::create_symlink("/dev/null", folder.path() / "null");
    fs::create_symlink("file/out.png", folder.path() / "into");
    REQUIRE(::mkfifo((folder.path() / "pipe").c_str(), 0600) == 0);
    struct Case {
        const char* name;
        fs::path target;
        std::string said;
    };  // relative to the folder
    const auto c = GENERATE(values<Case>({
        {"a file as the folder", "file/out.png", "cannot make the folder"},
        {"a file above the folder", "file/deeper/out.png", "cannot make the folder"},
        {"no such place in /proc", "/proc/terravox/out.png", "/proc/terravox"},
        {"the target is a folder", "taken", "this is a folder"},
        {"the target ends with a slash", "new/", "this is a folder"},
        {"the target is a pipe", "pipe", "a device, a pipe or a socket"},
        {"the target is a link to a device", "null", "a device, a pipe or a socket"},
        {"the target is a link into a folder that is a file", "into", "cannot make the folder"},
        {"a folder's name longer than file systems take", std::string(300, 'n') + "/out.png",
         "too long"},
        {"a file's name longer than file systems take", std::string(300, 'n') + ".png", "too long"},
        {"a link that leads to itself", "loop/out.png", "Too many levels"},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto target = folder.path() / c.target;
        const auto entries = entries_in(folder.path());
        CHECK_THROWS_AS(write_file_atomically(target, to_bytes("x")), util::Error);
        CHECK_THROWS_WITH(write_file_atomically(target, to_bytes("x")),
                          contains("write " + target.string()) && contains(c.said));
        CHECK(entries_in(folder.path()) == entries);
    }
    CHECK_THROWS_AS(check_writable(folder.path()), util::UsageError);
    CHECK_THROWS_AS(AtomicFile(""), util::UsageError);
    CHECK_NOTHROW(check_writable(folder.path() / "new.png"));
    CHECK_FALSE(fs::exists(folder.path() / "new.png"));
}

TEST_CASE("links are followed to what they lead to, be it there or not",
          "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    const fs::path& at = folder.path();
    fs::create_directory(at / "disk");
    std::ofstream(at / "disk" / "there") << "x";
    fs::create_symlink("disk/there", at / "link");
    fs::create_symlink(at / "link", at / "link to a link");
    fs::create_symlink("none", at / "disk" / "to nothing");
    fs::create_symlink("loop", at / "loop");
    CHECK(follow_links(at / "link") == at / "disk" / "there");
    CHECK(follow_links(at / "link to a link") == at / "disk" / "there");
    CHECK(follow_links(at / "disk" / "to nothing") == at / "disk" / "none");
    CHECK(follow_links(at / "disk" / "there") == at / "disk" / "there");
    CHECK(follow_links(at / "none") == at / "none");
    CHECK(follow_links("none") == "none");
    CHECK_THROWS_WITH(follow_links(at / "loop"), contains("loop: too many symbolic links"));
}

TEST_CASE("what a link leads to is written, and the link stays", "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    const fs::path& at = folder.path();
    fs::create_directory(at / "disk");
    std::ofstream(at / "disk" / "old") << "old";
    for (const char* const name : {"old", "new"}) {
        const fs::path link = at / (std::string("link to ") + name);
        fs::create_symlink(fs::path("disk") / name, link);
        write_file_atomically(link, to_bytes("text"));
        CHECK(fs::is_symlink(link));
        CHECK(read_content(at / "disk" / name) == "text");
    }
    CHECK(entries_in(at / "disk") == 2);
    CHECK(entries_in(at) == 3);
}

TEST_CASE("a link can be replaced instead, and leads to what it led to",
          "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    const fs::path& at = folder.path();
    std::ofstream(at / "precious") << "as it was";
    for (const char* const to : {"precious", "nothing", "/dev/null"}) {
        CAPTURE(to);
        fs::create_symlink(to, at / "plan.json");
        write_file_atomically(at / "plan.json", "{}", Links::kReplace);
        CHECK(fs::is_regular_file(fs::symlink_status(at / "plan.json")));
        CHECK(read_content(at / "plan.json") == "{}");
        CHECK(read_content(at / "precious") == "as it was");
        CHECK_FALSE(fs::exists(at / "nothing"));
        fs::remove(at / "plan.json");
    }
}

TEST_CASE("a link of another user is followed only out of a folder that is theirs alone",
          "[common][util][atomic_file]") {
    if (::geteuid() != 0) {
        WARN("not tried: only root can make links of other users");
        return;
    }
    constexpr uid_t kOther = 4711;
    const TemporaryFolder folder;
    const fs::path& at = folder.path();
    std::ofstream(at / "precious") << "as it was";
    fs::create_directory(at / "shared");
    const fs::path link = at / "shared" / "picture.png";
    fs::create_symlink(at / "precious", link);
    REQUIRE(::lchown(link.c_str(), kOther, static_cast<gid_t>(-1)) == 0);
    const auto set_folder = [&](uid_t owner, mode_t mode) {
        REQUIRE(::chown((at / "shared").c_str(), owner, static_cast<gid_t>(-1)) == 0);
        REQUIRE(::chmod((at / "shared").c_str(), mode) == 0);
    };
    for (const auto& [owner, mode] :
         {std::pair<uid_t, mode_t>{0, 01777}, {0, 0755}, {kOther, 0777}, {kOther, 0775}}) {
        CAPTURE(owner, mode);
        set_folder(owner, mode);
        CHECK_THROWS_WITH(write_file_atomically(link, "new"),
                          contains(link.string() + " is a symbolic link of another user") &&
                              contains("allowed: the name that it leads to, ") &&
                              contains((at / "precious").string()));
        CHECK_THROWS_AS(check_writable(link), Error);
    }
    CHECK(read_content(at / "precious") == "as it was");
    set_folder(kOther, 0755);
    write_file_atomically(link, "new");
    CHECK(read_content(at / "precious") == "new");
}

TEST_CASE("a commit without a written file fails and names the target",
          "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    AtomicFile file(folder.path() / "picture.png");
    CHECK_THROWS_AS(file.commit(), util::Error);
    CHECK_THROWS_WITH(file.commit(), contains("picture"));
    CHECK_FALSE(fs::exists(file.target()));
}

TEST_CASE("a name without a folder is written in the current folder",
          "[common][util][atomic_file]") {
    const TemporaryFolder folder;
    const auto before = fs::current_path();
    fs::current_path(folder.path());
    write_file_atomically("plain.txt", to_bytes("here"));
    fs::current_path(before);
    CHECK(read_content(folder.path() / "plain.txt") == "here");
}
