#include <algorithm>
#include <chrono>
#include <functional>
#include <map>
#include <random>
#include <set>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_reader.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/world.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/full_disk.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/common/voxel/synthetic_world.hpp"

using namespace terravox;
using namespace terravox::voxel;
using archive::Kind;
using terravox::test::contains;
using terravox::test::same_box;
using terravox::test::write_content;

namespace {

namespace fs = std::filesystem;

WorldInfo make_info() {
    WorldInfo info;
    info.title = "archive";
    info.bounds = {{-5120, -2048, -5120}, {5120, 2048, 5120}};
    info.levels = 9;
    info.voxel_m = 0.5;
    return info;
}

std::shared_ptr<const Box> box_at(const BoxKey& key) {
    BoxBuilder builder;
    for (int x = 0; x < 8; ++x)
        builder.add(x, (key.bx & 31) + x, 3, 5 + x + (key.bz & 7), true);
    return builder.build(
        key, [&](int x, int y, int z) { return test::SyntheticWorld::attr_at(x, y, z + key.by); });
}

void add(ArchiveWriter& writer, const BoxKey& key) {
    writer.add(key, Kind::kBox, compress(*box_at(key)));
}

void add_text(ArchiveWriter& writer, const BoxKey& key, const std::string& text) {
    writer.add(key, Kind::kHole, std::as_bytes(std::span(text)));
}

std::unique_ptr<World> open(const fs::path& file) {
    return open_archive(archive::file_source(file));
}

std::vector<BoxKey> many_keys(std::size_t count) {
    std::mt19937 random(5);
    std::map<BoxKey, int> keys;
    while (keys.size() < count)
        keys[{static_cast<int>(random() % 3), static_cast<std::int32_t>(random() % 40) - 20,
              static_cast<std::int32_t>(random() % 4) - 2,
              static_cast<std::int32_t>(random() % 40) - 20}] = 1;
    std::vector<BoxKey> out;
    for (const auto& [key, one] : keys)
        out.push_back(key);
    std::shuffle(out.begin(), out.end(), random);
    return out;
}

}  // namespace

TEST_CASE("an archive gives back every box that was put in, and air for the others",
          "[common][voxel][archive]") {
    const test::TemporaryFolder folder;
    const fs::path file = folder.path() / "a.tvx";
    const auto keys = many_keys(2500);  // three leaves of the index
    {
        ArchiveWriter writer(file, make_info(), 0);
        for (const BoxKey& key : keys)
            add(writer, key);
        CHECK_FALSE(fs::exists(file));
        writer.finish();
    }
    CHECK_FALSE(fs::exists(file.string() + ".part"));
    CHECK(is_archive(file));
    const auto world = open(file);
    CHECK(world->info().title == "archive");
    CHECK(world->info().bounds == make_info().bounds);
    CHECK(world->info().voxel_m == 0.5);
    for (const BoxKey& key : keys) {
        INFO(to_string(key));
        REQUIRE(same_box(world->box(key), box_at(key)));
    }
    const std::map<BoxKey, int> known = [&] {
        std::map<BoxKey, int> out;
        for (const BoxKey& key : keys)
            out[key] = 1;
        return out;
    }();
    int air = 0;
    for (int bx = -22; bx < 22; ++bx)
        for (int bz = -22; bz < 22; ++bz)
            if (!known.contains({1, bx, 0, bz})) {
                CHECK(world->box({1, bx, 0, bz}) == nullptr);
                ++air;
            }
    CHECK(air > 500);
    CHECK_THROWS_AS(world->box({9, 0, 0, 0}), util::UsageError);
    CHECK(world->column(0, 0, 0).by_begin == -8);
    CHECK(world->column(0, 0, 0).by_end == 8);
    CHECK(world->column(0, 99, 0).empty());
}

TEST_CASE("a hole of an archive is an error with its reason when it is requested",
          "[common][voxel][archive]") {
    const test::TemporaryFolder folder;
    const fs::path file = folder.path() / "a.tvx";
    ArchiveWriter writer(file, make_info(), 0);
    add_text(writer, {0, 1, 0, 1}, "the disk was wet");
    add(writer, {0, 2, 0, 1});
    writer.finish();
    const auto world = open(file);
    CHECK_THROWS_WITH(world->box({0, 1, 0, 1}),
                      contains("the disk was wet") && contains("0/1/0/1"));
    CHECK(world->box({0, 2, 0, 1}) != nullptr);
}

TEST_CASE("an archive of nothing is one", "[common][voxel][archive]") {
    const test::TemporaryFolder folder;
    ArchiveWriter writer(folder.path() / "a.tvx", make_info(), 0);
    writer.finish();
    CHECK(open(folder.path() / "a.tvx")->box({0, 0, 0, 0}) == nullptr);
}

TEST_CASE("what was added before a break is taken over, and the bytes are those of one go",
          "[common][voxel][archive]") {
    const test::TemporaryFolder folder;
    const fs::path whole = folder.path() / "whole.tvx";
    const fs::path broken = folder.path() / "broken.tvx";
    const auto keys = many_keys(40);
    {
        ArchiveWriter writer(whole, make_info(), 0);
        for (const BoxKey& key : keys)
            add(writer, key);
        writer.finish();
    }
    std::uint64_t keep = 0;
    {
        ArchiveWriter writer(broken, make_info(), 0);
        for (std::size_t i = 0; i < 25; ++i) {
            add(writer, keys[i]);
            if (i == 19)
                keep = writer.flush();
        }
        writer.flush();
    }
    CHECK_THROWS_WITH(open(broken.string() + ".part"), contains("never finished"));
    {
        ArchiveWriter writer(broken, make_info(), keep);
        CHECK(writer.entries() == 20);
        for (std::size_t i = 20; i < keys.size(); ++i)
            add(writer, keys[i]);
        writer.finish();
    }
    CHECK((test::read_content(whole) == test::read_content(broken)));

    SECTION("but not when it is not there, or damaged") {
        write_content(broken.string() + ".part", test::read_content(whole).substr(0, 300));
        CHECK_THROWS_WITH(ArchiveWriter(broken, make_info(), keep),
                          contains("the records to keep are"));
        std::string bytes = test::read_content(whole);
        bytes[keep / 2] = static_cast<char>(bytes[keep / 2] ^ 1);
        write_content(broken.string() + ".part", bytes);
        CHECK_THROWS_WITH(ArchiveWriter(broken, make_info(), keep),
                          contains("the records to keep are"));
    }
}

TEST_CASE("entries come back in the order of an index, however many are in memory at a time",
          "[common][voxel][archive]") {
    const test::TemporaryFolder folder;
    std::mt19937 random(7);
    for (const std::size_t count : {0, 1, 5, 10, 11, 20'000}) {
        std::vector<archive::Entry> entries;
        for (std::size_t i = 0; i < count; ++i)
            entries.push_back({archive::to_key(BoxKey{static_cast<int>(random() % 3),
                                                      static_cast<std::int32_t>(i) - 9, 2, -3}),
                               i, 7, archive::Kind::kBox});
        std::shuffle(entries.begin(), entries.end(), random);
        for (const std::size_t run : {1, 5, 9'000, 1 << 20}) {
            if (count / run > 1000)
                continue;
            CAPTURE(count, run);
            archive::EntryRuns runs(folder.path() / "a.tvx", run);
            for (const archive::Entry& entry : entries)
                runs.add(entry);
            CHECK(runs.size() == count);
            std::vector<archive::Entry> sorted;
            runs.each_sorted([&](const archive::Entry& entry) { sorted.push_back(entry); });
            CHECK(std::adjacent_find(sorted.begin(), sorted.end(),
                                     [](const archive::Entry& a, const archive::Entry& b) {
                                         return !archive::before(a.key, b.key);
                                     }) == sorted.end());
            std::set<std::uint64_t> offsets;
            for (const archive::Entry& entry : sorted)
                offsets.insert(entry.offset);
            CHECK(sorted.size() == count);
            CHECK(offsets.size() == count);
            CHECK(fs::is_empty(folder.path()));
        }
    }
    archive::EntryRuns full(folder.path() / "a.tvx", 1);
    const test::FullDisk disk(sizeof(archive::Entry));
    full.add({});
    full.add({});
    CHECK_THROWS_WITH(full.add({}), contains("write the index of") && contains("too large"));
}

TEST_CASE("a link at the name of an unfinished archive is refused, and leads to what it led to",
          "[common][voxel][archive]") {
    const test::TemporaryFolder folder;
    const fs::path precious = folder.path() / "precious";
    write_content(precious, "as it was");
    fs::create_symlink(precious, folder.path() / "a.tvx.part");
    CHECK_THROWS_WITH(ArchiveWriter(folder.path() / "a.tvx", make_info(), 0),
                      contains("a.tvx.part is a symbolic link"));
    CHECK(test::read_content(precious) == "as it was");
    CHECK_FALSE(fs::exists(folder.path() / "a.tvx"));
}

TEST_CASE("no archive with a flipped bit or a lost end gives wrong boxes",
          "[common][voxel][archive]") {
    const test::TemporaryFolder folder;
    const fs::path file = folder.path() / "a.tvx";
    const auto keys = many_keys(12);
    {
        ArchiveWriter writer(file, make_info(), 0);
        for (const BoxKey& key : keys)
            add(writer, key);
        writer.finish();
    }
    const std::string whole = test::read_content(file);
    // Either an Error somewhere, or the very boxes: the facts about the world are text that no
    // checksum holds.
    const auto right_or_refused = [&](const std::string& bytes) {
        write_content(file, bytes);
        try {
            const auto world = open(file);
            for (const BoxKey& key : keys)
                if (key.level < world->info().levels && !same_box(world->box(key), box_at(key)))
                    return false;
        } catch (const util::Error&) {
        }
        return true;
    };
    std::mt19937 random(11);
    for (int i = 0; i < 200; ++i) {
        std::string bytes = whole;
        const std::size_t at = random() % bytes.size();
        bytes[at] = static_cast<char>(bytes[at] ^ 1 << random() % 8);
        INFO("byte " << at);
        CHECK(right_or_refused(bytes));
    }
    for (const std::size_t length : {std::size_t{0}, std::size_t{1}, std::size_t{63},
                                     std::size_t{64}, whole.size() / 2, whole.size() - 1}) {
        INFO("length " << length);
        CHECK(right_or_refused(whole.substr(0, length)));
    }
    write_content(file, whole);
    CHECK_NOTHROW(open(file));
}

TEST_CASE("bytes of an archive that were read stay what they were, whatever becomes of the file",
          "[common][voxel][archive]") {
    const test::TemporaryFolder folder;
    const fs::path file = folder.path() / "a.tvx";
    constexpr std::size_t kBytes = 100'000;
    const std::string good(kBytes, 'a');
    write_content(file, good);
    const auto source = archive::file_source(file);
    std::vector<std::byte> room;
    std::vector<std::byte> other;
    const auto bytes = source->read(0, good.size(), room);
    // The cases outlive the run that made them: each is given the file of its own run.
    struct Case {
        const char* name;
        std::function<void(const fs::path&)> deed;
        const char* said;
    };
    const auto c = GENERATE(values<Case>({
        {"cut short in place", [](const fs::path& at) { fs::resize_file(at, 0); }, "cut short"},
        {"overwritten in place",
         [](const fs::path& at) { write_content(at, std::string(kBytes, 'b')); },
         "changed while it was open"},
        {"made longer", [](const fs::path& at) { fs::resize_file(at, 2 * kBytes); },
         "changed while it was open"},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto before = fs::last_write_time(file);
        c.deed(file);
        fs::last_write_time(
            file, before + std::chrono::seconds(1));  // clocks of file systems may be coarse
        CHECK(std::all_of(bytes.begin(), bytes.end(),
                          [](std::byte b) { return b == std::byte{'a'}; }));
        CHECK_THROWS_WITH(source->read(0, 100, other), contains("a.tvx") && contains(c.said));
        CHECK_THROWS_AS(source->read(0, 100, other), ChangedError);
    }
    SECTION("replaced by another file of its name") {
        write_content(folder.path() / "b.tvx", std::string(good.size(), 'b'));
        fs::rename(folder.path() / "b.tvx", file);
        CHECK(bytes[0] == std::byte{'a'});
        CHECK(source->read(50'000, 1, other)[0] == std::byte{'a'});
    }
}

TEST_CASE(
    "an archive that is overwritten while it is open gives its own boxes or an error, never "
    "another's",
    "[common][voxel][archive]") {
    const test::TemporaryFolder folder;
    const fs::path file = folder.path() / "a.tvx";
    const fs::path other = folder.path() / "b.tvx";
    const BoxKey key{0, 1, 0, 1};
    const auto write = [&](const fs::path& to, Material material, int source_class) {
        ArchiveWriter writer(to, make_info(), 0);
        BoxBuilder builder;
        builder.add(0, 0, 0, 1, true);
        const auto attr = [&](int, int, int) {
            return VoxelAttr{material, static_cast<std::uint8_t>(source_class), 0, 0, {}, 0};
        };
        writer.add(key, Kind::kBox, compress(*builder.build(key, attr)));
        writer.finish();
        return test::read_content(to);
    };
    const std::string whole = write(file, Material::kGrass, 0);
    // Of the same length, so that the index of the first leads to a sound box of the second, which
    // has the same key.
    std::string painted;
    for (int source_class = 0; source_class < 256 && painted.size() != whole.size(); ++source_class)
        painted = write(other, Material::kWater, source_class);
    REQUIRE(whole.size() == painted.size());
    struct Case {
        const char* name;
        std::string bytes;
    };
    const auto c =
        GENERATE_REF(values<Case>({{"by another archive", painted},
                                   {"by nothing", {}},
                                   {"by the half of it", whole.substr(0, whole.size() / 2)}}));
    DYNAMIC_SECTION(c.name) {
        const auto world = open(file);
        CHECK(world->box(key)->voxel(0, 0, 0)->material == Material::kGrass);
        const auto before = fs::last_write_time(file);
        write_content(file, c.bytes);
        fs::last_write_time(file, before + std::chrono::seconds(1));
        CHECK_THROWS_AS(world->box(key), util::Error);
    }
}

TEST_CASE(
    "an archive whose bounds do not fit its levels is refused: a picture of its air would never "
    "end",
    "[common][voxel][archive]") {
    struct Case {
        const char* name;
        VoxelBounds bounds;
        int levels;
        const char* said;
    };
    constexpr std::int32_t kWide = 1 << 26;
    constexpr std::int32_t kHigh = 1 << 28;
    constexpr std::int32_t kMore = 1 << 27;
    const auto c = GENERATE(values<Case>({
        {"as wide as its levels", {{0, 0, 0}, {128, 256, 128}}, 2, ""},
        {"levels that it does not need", {{0, 0, 0}, {64, 256, 64}}, 21, ""},
        {"as wide as the index can say", {{-kWide, 0, -kWide}, {kWide, 256, kWide}}, 20, ""},
        {"wider than its levels",
         {{0, 0, 0}, {129, 256, 64}},
         2,
         "levels = 2; bounds of this width need at least 3"},
        {"much wider than its levels",
         {{-kWide, 0, -kWide}, {kWide, 256, kWide}},
         17,
         "need at least 20"},
        {"as wide as 32 bits can say",
         {{-(1 << 30), 0, -(1 << 30)}, {1 << 30, 256, 1 << 30}},
         21,
         "2^20 boxes from the origin"},
        {"higher than the index can say",
         {{0, 0, 0}, {1 << 25, kHigh + 1, 64}},
         20,
         "2^20 boxes from the origin"},
        {"farther out than the index can say",
         {{kMore, 0, 0}, {kMore + 64, 256, 64}},
         1,
         "2^20 boxes from the origin"},
    }));
    DYNAMIC_SECTION(c.name) {
        const test::TemporaryFolder folder;
        const fs::path file = folder.path() / "a.tvx";
        WorldInfo info = make_info();
        info.bounds = c.bounds;
        info.levels = c.levels;
        ArchiveWriter(file, info, 0).finish();
        if (*c.said == '\0')
            CHECK(open(file)->box({0, 0, 0, 0}) == nullptr);
        else
            CHECK_THROWS_WITH(open(file), contains("a.tvx") && contains(c.said));
    }
}

TEST_CASE("an index that names boxes outside of the bounds of its archive is refused",
          "[common][voxel][archive]") {
    struct Case {
        const char* name;
        BoxKey key;
    };
    const auto c = GENERATE(values<Case>({
        {"too far west", {0, -81, 0, 0}},
        {"too far south", {0, 0, 0, 80}},
        {"too high", {0, 0, 8, 0}},
        {"of a level that it does not have", {9, 0, 0, 0}},
        {"of a coarse level, too far east", {8, 1, 0, 0}},
    }));
    const test::TemporaryFolder folder;
    const fs::path file = folder.path() / "a.tvx";
    const BoxKey good{0, 0, 0, 0};
    DYNAMIC_SECTION(c.name) {
        ArchiveWriter writer(file, make_info(), 0);
        add(writer, c.key);
        SECTION("alone") {
            writer.finish();
            CHECK_THROWS_WITH(open(file),
                              contains(to_string(c.key) + ", which lies outside of its bounds"));
        }
        SECTION("behind one that lies inside") {
            if (archive::before(archive::to_key(c.key), archive::to_key(good)))
                return;
            add(writer, good);
            writer.finish();
            CHECK_THROWS_WITH(open(file)->box(good),
                              contains(to_string(c.key) + ", which lies outside of its bounds"));
        }
    }
}

TEST_CASE("files that are no archives are refused by name", "[common][voxel][archive]") {
    const test::TemporaryFolder folder;
    const fs::path file = folder.path() / "a.tvx";
    CHECK_THROWS_WITH(open(file), contains("no such file"));
    write_content(file, std::string(200, 'x'));
    CHECK_THROWS_WITH(open(file), contains("a.tvx") && contains("not a box archive"));
    CHECK_FALSE(is_archive(file));
    CHECK_FALSE(is_archive(folder.path()));
    ArchiveWriter(file, make_info(), 0).finish();
    std::string bytes = test::read_content(file);
    bytes[8] = 9;
    write_content(file, bytes);
    CHECK_THROWS_WITH(open(file), contains("version 9"));
    CHECK_THROWS_WITH(ArchiveWriter(folder.path() / "b.tvx", make_info(), 0)
                          .add({0, 1 << 20, 0, 0}, Kind::kBox, {}),
                      contains("2^20"));
}
