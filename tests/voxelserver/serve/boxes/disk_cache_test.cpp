#include "voxelserver/serve/boxes/disk_cache.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <map>
#include <memory>
#include <random>
#include <thread>

#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/data/sqlite/database.hpp"

using namespace terravox;
using boxes::DiskCache;
using boxes::Item;
using boxes::Kind;
using voxel::BoxKey;
using voxel::InputExtent;

namespace {

constexpr std::uint64_t kPlenty = std::uint64_t{64} << 20;

// The inputs of column (bx, bz) have a version each.
struct Inputs {
    std::map<std::pair<int, int>, std::uint64_t> versions;
    voxel::Fingerprint of(const InputExtent& r) const {
        voxel::Fingerprint out{7, 11};
        for (const auto& [column, version] : versions)
            if (column.first >= r.min_bx && column.first < r.max_bx && column.second >= r.min_bz &&
                column.second < r.max_bz) {
                out[0] += version;
                out[1] ^= version * 31;
            }
        return out;
    }
    DiskCache::MakeFingerprint function() const {
        return [this](const InputExtent& r) { return of(r); };
    }
};

Item item(const std::string& bytes, const InputExtent& reach = {0, 0, 1, 1},
          std::uint64_t tag = 5) {
    return {tag, std::make_shared<const std::string>(bytes), reach};
}

std::string to_text(const std::optional<Item>& found) {
    return !found ? "absent" : found->bytes ? *found->bytes : "air";
}

std::string noise(std::size_t bytes, unsigned seed) {
    std::mt19937 random(seed);
    std::string out(bytes, '\0');
    for (char& c : out)
        c = static_cast<char>(random());
    return out;
}

}  // namespace

TEST_CASE("an item that was put is there for the next process", "[voxelserver][boxes][disk]") {
    const test::TemporaryFolder folder;
    const Inputs inputs;
    const BoxKey key{3, -5, 2, 1000000}, far{0, -1000001, 7, 1000001};
    {
        DiskCache cache(folder.path() / "deeper" / "boxes.sqlite", kPlenty, inputs.function());
        cache.put(Kind::kBox, key, item("one", {-5, 2, 9, 12}, 0xfedcba9876543210));
        cache.put(Kind::kMapTile, key, item("tile"));
        cache.put(Kind::kBox, far, {0, nullptr, {}});
    }
    DiskCache cache(folder.path() / "deeper" / "boxes.sqlite", kPlenty, inputs.function());
    const auto found = cache.find(Kind::kBox, key);
    REQUIRE(found);
    CHECK(*found->bytes == "one");
    CHECK(found->tag == 0xfedcba9876543210);
    CHECK(found->reach == InputExtent{-5, 2, 9, 12});
    CHECK(to_text(cache.find(Kind::kMapTile, key)) == "tile");
    CHECK(to_text(cache.find(Kind::kBox, far)) == "air");
    CHECK(to_text(cache.find(Kind::kBox, {3, -5, 2, 1000001})) == "absent");
    // Coordinates two million boxes apart share a Morton code, not an item.
    CHECK(to_text(cache.find(Kind::kBox, {3, -5 + (1 << 21), 2, 1000000})) == "absent");
    cache.flush();
    CHECK(cache.stats().entries == 3);
    CHECK(cache.keys(Kind::kBox, 3, 10) == std::vector<BoxKey>{key});
}

TEST_CASE(
    "a change of inputs makes just those items useless that it reached, and taking it back makes "
    "them good",
    "[voxelserver][boxes][disk]") {
    const test::TemporaryFolder folder;
    Inputs inputs;
    DiskCache cache(folder.path() / "boxes.sqlite", kPlenty, inputs.function());
    const BoxKey near{0, 0, 0, 0}, wide{0, 1, 0, 0}, away{0, 9, 0, 0};
    cache.put(Kind::kBox, near, item("near", {0, 0, 1, 1}));
    cache.put(Kind::kBox, wide, item("wide", {-3, 0, 4, 1}));
    cache.put(Kind::kBox, away, item("away", {8, 0, 10, 1}));
    cache.flush();
    inputs.versions[{0, 0}] = 1;
    CHECK(to_text(cache.find(Kind::kBox, near)) == "absent");
    CHECK(to_text(cache.find(Kind::kBox, wide)) == "absent");
    CHECK(to_text(cache.find(Kind::kBox, away)) == "away");
    CHECK(cache.keys(Kind::kBox, 0, 10) == std::vector<BoxKey>{away});
    cache.put(Kind::kBox, near, item("nearer", {0, 0, 1, 1}));
    cache.flush();
    CHECK(to_text(cache.find(Kind::kBox, near)) == "nearer");
    inputs.versions.clear();
    CHECK(to_text(cache.find(Kind::kBox, near)) == "near");
    CHECK(to_text(cache.find(Kind::kBox, wide)) == "wide");
}

TEST_CASE("the file keeps to its limit, and what was put last stays",
          "[voxelserver][boxes][disk]") {
    const test::TemporaryFolder folder;
    const Inputs inputs;
    constexpr std::uint64_t kLimit = std::uint64_t{2} << 20;
    const auto file = folder.path() / "boxes.sqlite";
    {
        DiskCache cache(file, kLimit, inputs.function());
        for (int i = 0; i < 600; ++i) {
            cache.put(Kind::kBox, {0, i, 0, 0}, item(noise(10'000, static_cast<unsigned>(i))),
                      DiskCache::WhenFull::kWait);
            if (i % 50 == 0) {
                cache.flush();
                CHECK(cache.stats().bytes <= kLimit);
            }
        }
        cache.flush();
        CHECK(cache.stats().bytes <= kLimit);
        CHECK(cache.stats().evictions > 300);
        CHECK(to_text(cache.find(Kind::kBox, {0, 599, 0, 0})) == noise(10'000, 599));
        CHECK(to_text(cache.find(Kind::kBox, {0, 0, 0, 0})) == "absent");
        cache.put(Kind::kBox, {0, 1000, 0, 0},
                  item(noise(kLimit / 2, 1)));  // would push out nearly all others
        cache.flush();
        CHECK(to_text(cache.find(Kind::kBox, {0, 1000, 0, 0})) == "absent");
    }
    CHECK(std::filesystem::file_size(file) <= kLimit + 65536);
    // A lower limit holds after the next write.
    DiskCache cache(file, kLimit / 4, inputs.function());
    cache.put(Kind::kBox, {0, 0, 0, 0}, item("new"));
    cache.flush();
    CHECK(cache.stats().bytes <= kLimit / 4);
    CHECK(to_text(cache.find(Kind::kBox, {0, 0, 0, 0})) == "new");
}

TEST_CASE("bits that changed on the disk are found out", "[voxelserver][boxes][disk]") {
    const test::TemporaryFolder folder;
    const Inputs inputs;
    const auto file = folder.path() / "boxes.sqlite";
    const char* change = GENERATE("UPDATE item SET bytes = x'6f6e66'", "UPDATE item SET tag = 6",
                                  "UPDATE item SET bytes = NULL", "UPDATE item SET max_bx = 2",
                                  "UPDATE item SET by = 1, morton = 2");
    INFO(change);
    {
        DiskCache cache(file, kPlenty, inputs.function());
        cache.put(Kind::kBox, {0, 0, 0, 0}, item("one"));
    }
    test::Database(file).run(change);
    DiskCache cache(file, kPlenty, inputs.function());
    for (const BoxKey& key : {BoxKey{0, 0, 0, 0}, BoxKey{0, 0, 1, 0}})
        CHECK(to_text(cache.find(Kind::kBox, key)) == "absent");
    CHECK(cache.stats().damaged == 1);
    cache.put(Kind::kBox, {0, 0, 0, 0}, item("again"));
    cache.flush();
    CHECK(to_text(cache.find(Kind::kBox, {0, 0, 0, 0})) == "again");
}

TEST_CASE("a link at the name of the cache file is not followed", "[voxelserver][boxes][disk]") {
    const test::TemporaryFolder folder;
    const Inputs inputs;
    const auto other = folder.path() / "other.sqlite";
    test::Database(other).run("CREATE TABLE mine (a)");
    const std::string before = test::read_content(other);
    std::filesystem::create_symlink(other, folder.path() / "boxes.sqlite");
    {
        DiskCache cache(folder.path() / "boxes.sqlite", kPlenty, inputs.function());
        cache.put(Kind::kBox, {0, 0, 0, 0}, item("one"));
        cache.flush();
        CHECK(to_text(cache.find(Kind::kBox, {0, 0, 0, 0})) == "absent");
    }
    CHECK((test::read_content(other) == before));
    // Links in the names of folders are ordinary.
    std::filesystem::create_directory(folder.path() / "disk");
    std::filesystem::create_directory_symlink("disk", folder.path() / "cache");
    DiskCache cache(folder.path() / "cache" / "boxes.sqlite", kPlenty, inputs.function());
    cache.put(Kind::kBox, {0, 0, 0, 0}, item("one"));
    cache.flush();
    CHECK(to_text(cache.find(Kind::kBox, {0, 0, 0, 0})) == "one");
}

TEST_CASE(
    "a file that is no database, or half of one, is begun anew; a folder that cannot be costs only "
    "the disk",
    "[voxelserver][boxes][disk]") {
    const test::TemporaryFolder folder;
    const Inputs inputs;
    const auto file = folder.path() / "boxes.sqlite";
    const int damage = GENERATE(0, 1, 2);
    CAPTURE(damage);
    if (damage == 0)
        std::ofstream(file) << "this is not SQLite, and longer than its header, which has a "
                               "hundred bytes, so that it is looked at closely .......";
    if (damage > 0) {
        DiskCache cache(file, kPlenty, inputs.function());
        for (int i = 0; i < 50; ++i)
            cache.put(Kind::kBox, {0, i, 0, 0}, item(noise(9000, static_cast<unsigned>(i))));
    }
    if (damage == 1)
        std::filesystem::resize_file(file, std::filesystem::file_size(file) / 2);
    if (damage == 2) {
        std::fstream out(file, std::ios::in | std::ios::out | std::ios::binary);
        const std::string zeros(60'000, '\xaa');
        out.seekp(8192);
        out.write(zeros.data(), static_cast<std::streamsize>(zeros.size()));
    }
    const auto use = [&] {
        DiskCache cache(file, kPlenty, inputs.function());
        for (int i = 0; i < 50; ++i)
            if (const auto found = cache.find(Kind::kBox, {0, i, 0, 0}))
                CHECK(*found->bytes == noise(9000, static_cast<unsigned>(i)));
        cache.put(Kind::kBox, {0, 0, 0, 0}, item(noise(9000, 0)));
        cache.flush();
    };
    use();
    use();  // whatever was damaged has been noticed by now
    DiskCache cache(file, kPlenty, inputs.function());
    CHECK(to_text(cache.find(Kind::kBox, {0, 0, 0, 0})) == noise(9000, 0));

    DiskCache nowhere("/proc/no/such/boxes.sqlite", kPlenty, inputs.function());
    nowhere.put(Kind::kBox, {0, 0, 0, 0}, item("one"));
    nowhere.flush();
    CHECK(to_text(nowhere.find(Kind::kBox, {0, 0, 0, 0})) == "absent");
}

TEST_CASE("a file that another process holds locked costs the disk, nothing more",
          "[voxelserver][boxes][disk]") {
    const test::TemporaryFolder folder;
    const Inputs inputs;
    const auto file = folder.path() / "boxes.sqlite";
    {
        DiskCache(file, kPlenty, inputs.function()).put(Kind::kBox, {0, 0, 0, 0}, item("one"));
    }
    {
        test::Database locked(file);
        locked.run("PRAGMA locking_mode=EXCLUSIVE; BEGIN EXCLUSIVE; UPDATE item SET used = 1");
        DiskCache cache(file, kPlenty, inputs.function());
        cache.put(Kind::kBox, {0, 1, 0, 0}, item("two"));
        cache.flush();
        CHECK(to_text(cache.find(Kind::kBox, {0, 0, 0, 0})) == "absent");
        CHECK(cache.keys(Kind::kBox, 0, 10).empty());
        CHECK(cache.failing());
    }
    DiskCache cache(file, kPlenty, inputs.function());
    CHECK(to_text(cache.find(Kind::kBox, {0, 0, 0, 0})) == "one");
}

TEST_CASE("two caches on one file see each other's items", "[voxelserver][boxes][disk]") {
    const test::TemporaryFolder folder;
    const Inputs inputs;
    DiskCache a(folder.path() / "boxes.sqlite", kPlenty, inputs.function()),
        b(folder.path() / "boxes.sqlite", kPlenty, inputs.function());
    std::vector<std::thread> threads;
    for (int t = 0; t < 4; ++t)
        threads.emplace_back([&, t] {
            DiskCache& mine = t % 2 == 0 ? a : b;
            for (int i = 0; i < 100; ++i) {
                mine.put(Kind::kBox, {0, i, t, 0}, item(std::to_string(1000 * t + i)),
                         DiskCache::WhenFull::kWait);
                (void)mine.find(Kind::kBox, {0, i / 2, t, 0});
            }
        });
    for (auto& t : threads)
        t.join();
    a.flush();
    b.flush();
    for (int t = 0; t < 4; ++t)
        for (int i = 0; i < 100; ++i)
            CHECK(to_text((t % 2 == 0 ? b : a).find(Kind::kBox, {0, i, t, 0})) ==
                  std::to_string(1000 * t + i));
}

TEST_CASE("a process killed while it writes leaves whole items or none",
          "[voxelserver][boxes][disk]") {
    const test::TemporaryFolder folder;
    const Inputs inputs;
    const auto file = folder.path() / "boxes.sqlite";
    for (int round = 0; round < 6; ++round) {
        int done_pipe[2];
        REQUIRE(pipe(done_pipe) == 0);
        const pid_t child = fork();
        REQUIRE(child >= 0);
        if (child == 0) {
            DiskCache cache(file, kPlenty, inputs.function());
            for (int i = 0;; ++i) {
                cache.put(Kind::kBox, {0, i % 500, round, 0},
                          item(noise(3000, static_cast<unsigned>(i % 500))),
                          DiskCache::WhenFull::kWait);
                // What is flushed is there; what comes after is being written when the process is
                // killed.
                if (i != 10 * round)
                    continue;
                cache.flush();
                const char done = 1;
                if (write(done_pipe[1], &done, 1) != 1)
                    _exit(1);
            }
        }
        close(done_pipe[1]);
        char done = 0;
        REQUIRE(read(done_pipe[0], &done, 1) == 1);
        kill(child, SIGKILL);
        close(done_pipe[0]);
        waitpid(child, nullptr, 0);
        DiskCache cache(file, kPlenty, inputs.function());
        for (int i = 0; i < 500; ++i) {
            const auto one = cache.find(Kind::kBox, {0, i, round, 0});
            INFO("round " << round << ", item " << i);
            if (i <= 10 * round)
                CHECK(one);
            if (one)
                CHECK(*one->bytes == noise(3000, static_cast<unsigned>(i)));
        }
        CHECK(cache.stats().damaged == 0);
    }
}
