#include "raytracer/apps/publish/site.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <vector>

#include "common/util/error.hpp"
#include "tests/catch.hpp"
#include "tests/common/temporary_folder.hpp"

using namespace terravox;
using publish::SiteFolder;
using terravox::test::contains;
using terravox::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

void put(const fs::path& file, const std::string& bytes = "x") {
    fs::create_directories(file.parent_path());
    std::ofstream(file, std::ios::binary) << bytes;
}

std::vector<std::string> listed(const fs::path& folder) {
    std::vector<std::string> out;
    for (const auto& entry : fs::directory_iterator(folder))
        out.push_back(entry.path().filename().string());
    std::sort(out.begin(), out.end());
    return out;
}

void write_some_site(const fs::path& folder) {
    publish::SiteFacts facts;
    facts.title = "T";
    facts.archive = {{"place.tvx", 5}};
    facts.views = {{"Start", {1, 2, 3}, {4, 5, 6}, 40}};
    publish::write_site(folder, facts);
}

// As a process that is killed: nothing is removed.
void leave_begun(const fs::path& folder) {
    put(folder / publish::kSiteLock, "process 1 of elsewhere\n");
    put(folder / "place.tvx.part");
}

}  // namespace

TEST_CASE("a site is written to a new or empty folder, over a site, or where a run was killed",
          "[publish]") {
    struct Case {
        const char* name;
        void (*fill)(const fs::path& folder);
        bool allowed;
    };
    const auto c = GENERATE(values<Case>({
        {"none yet", [](const fs::path&) {}, true},
        {"empty", [](const fs::path& folder) { fs::create_directories(folder); }, true},
        {"a site", write_some_site, true},
        {"a run that was killed", leave_begun, true},
        {"the archive itself", [](const fs::path& folder) { put(folder / "input.tvx"); }, true},
        {"a page of somebody", [](const fs::path& folder) { put(folder / "index.html"); }, false},
        {"something hidden", [](const fs::path& folder) { put(folder / ".git/HEAD"); }, false},
        {"another archive", [](const fs::path& folder) { put(folder / "place.tvx"); }, false},
        {"a place.json of something else",
         [](const fs::path& folder) { put(folder / "place.json", R"({"place": "Bled"})"); }, false},
        {"a link in the place of the lock",
         [](const fs::path& folder) {
             put(folder / "index.html");
             fs::create_symlink("index.html", folder / publish::kSiteLock);
         },
         false},
    }));
    DYNAMIC_SECTION(c.name) {
        const TemporaryFolder place;
        const fs::path folder = place.path() / "site";
        c.fill(folder);
        const std::vector<std::string> before =
            fs::exists(folder) ? listed(folder) : std::vector<std::string>();
        const fs::path input = folder / "input.tvx";
        if (c.allowed) {
            CHECK_NOTHROW(SiteFolder(folder, input, false));
        } else {
            CHECK_THROWS_AS(SiteFolder(folder, input, false), util::UsageError);
            CHECK_THROWS_WITH(SiteFolder(folder, input, false),
                              contains(before.back()) && contains("--overwrite"));
            CHECK(listed(folder) == before);
        }
    }
}

TEST_CASE("a folder with other files takes a site where they may be overwritten", "[publish]") {
    const TemporaryFolder folder;
    put(folder.path() / "index.html");
    CHECK_NOTHROW(SiteFolder(folder.path(), {}, true));
}

TEST_CASE("a file takes no site", "[publish]") {
    const TemporaryFolder folder;
    put(folder.path() / "notes.txt");
    CHECK_THROWS_AS(SiteFolder(folder.path() / "notes.txt", {}, false), util::UsageError);
    CHECK_THROWS_WITH(SiteFolder(folder.path() / "notes.txt", {}, true),
                      contains("it is a file; allowed: a new or empty folder"));
}

TEST_CASE("one process at a time writes a site to a folder", "[publish]") {
    const TemporaryFolder folder;
    {
        const SiteFolder first(folder.path(), {}, false);
        for (const bool overwrite : {false, true})
            CHECK_THROWS_WITH(SiteFolder(folder.path(), {}, overwrite),
                              contains("writes a site there"));
    }
    CHECK_NOTHROW(SiteFolder(folder.path(), {}, false));
}

TEST_CASE("a folder says that its site is not complete, and only then", "[publish]") {
    const TemporaryFolder folder;
    {
        const SiteFolder nothing_written(folder.path(), {}, false);
    }
    CHECK(listed(folder.path()).empty());
    {
        const SiteFolder failed(folder.path(), {}, false);
        put(folder.path() / "place.tvx.part");
    }
    CHECK(fs::exists(folder.path() / publish::kSiteLock));
    {
        const SiteFolder complete(folder.path(), {}, false);
        write_some_site(folder.path());
    }
    CHECK_FALSE(fs::exists(folder.path() / publish::kSiteLock));
}

TEST_CASE("unfinished files of killed runs are removed, and those of others are not", "[publish]") {
    const TemporaryFolder folder;
    write_some_site(folder.path());
    const std::vector<std::string> ours = {
        ".place.part-12-3.tvx", ".place-0001.part-12-3.part", ".preview.part-12-4294967295.jpg",
        ".index.part-1-00c0ffee12345678.html", "viewer/.worker.part-1-1.js"};
    const std::vector<std::string> others = {".notes.part-12-3.txt", ".place.part-mine.tvx",
                                             ".place.part-12-3.txt", "place.part-12-3.tvx",
                                             "viewer/.mine.part-1-1.js"};
    for (const auto* names : {&ours, &others})
        for (const std::string& name : *names)
            put(folder.path() / name);
    const SiteFolder held(folder.path(), {}, false);
    for (const std::string& name : ours) {
        INFO(name);
        CHECK_FALSE(fs::exists(folder.path() / name));
    }
    for (const std::string& name : others) {
        INFO(name);
        CHECK(fs::exists(folder.path() / name));
    }
}

TEST_CASE("a copied archive has the permissions of new files", "[publish]") {
    const TemporaryFolder folder;
    const fs::path from = folder.path() / "mine.tvx";
    const fs::path to = folder.path() / "place.tvx";
    const std::string bytes((std::size_t{5} << 20) + 3, 'v');
    put(from, bytes);
    ::chmod(from.c_str(), 0600);
    const mode_t before = ::umask(022);
    publish::copy_archive(from, to);
    ::umask(before);
    struct stat facts{};
    REQUIRE(::stat(to.c_str(), &facts) == 0);
    CHECK((facts.st_mode & 0777) == 0644);
    std::ifstream in(to, std::ios::binary);
    CHECK(std::string(std::istreambuf_iterator<char>(in), {}) == bytes);
    publish::copy_archive(to, to);
    CHECK(fs::file_size(to) == bytes.size());
}
