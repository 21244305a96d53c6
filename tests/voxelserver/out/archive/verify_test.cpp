#include "voxelserver/out/archive/verify.hpp"

#include <algorithm>
#include <fstream>
#include <functional>
#include <map>
#include <random>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/common/voxel/synthetic_world.hpp"
#include "voxelserver/out/archive/archive_files.hpp"

using namespace terravox;
using namespace terravox::archive_tools;
using terravox::test::contains;
using terravox::test::read_content;
using voxel::BoxKey;
using voxel::archive::Kind;

namespace {

using BoxPtr = std::shared_ptr<const voxel::Box>;
/// Boxes by key; nullptr: a hole.
using Boxes = std::map<BoxKey, BoxPtr>;

const voxel::VoxelBounds kBounds{{-100, 0, -130}, {150, 200, 90}};

/// All boxes of a small world, its coarse levels made of the finest.
Boxes collect_boxes(voxel::World& world) {
    Boxes out;
    for (int level = 0; level < world.info().levels; ++level) {
        const voxel::BoxRange range = voxel::boxes_over(world.info().bounds, level);
        for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
            for (std::int32_t by = range.min.by; by < range.max.by; ++by)
                for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz)
                    if (auto box = world.box({level, bx, by, bz}))
                        out.emplace(BoxKey{level, bx, by, bz}, std::move(box));
    }
    return out;
}

class Archive {
public:
    Archive() : m_world(kBounds), boxes(collect_boxes(m_world)) {}

    /// Writes the boxes as an archive.
    std::filesystem::path write() {
        const std::filesystem::path file = m_folder.path() / "world.tvx";
        voxel::ArchiveWriter writer(file, m_world.info(), 0);
        const std::string reason = "no data";
        for (const auto& [key, box] : boxes) {
            if (box)
                writer.add(key, Kind::kBox, voxel::compress(*box));
            else
                writer.add(key, Kind::kHole, std::as_bytes(std::span(reason)));
        }
        writer.finish();
        return file;
    }
    [[nodiscard]] int levels() const { return m_world.info().levels; }
    /// The first box of a level.
    [[nodiscard]] BoxKey first(int level) const {
        return boxes.lower_bound({level, -1000, -1000, -1000})->first;
    }
    /// The box of the coarsest level.
    [[nodiscard]] BoxKey top() const { return boxes.rbegin()->first; }

private:
    test::TemporaryFolder m_folder;
    test::SyntheticWorld m_world;

public:
    Boxes boxes;
};

}  // namespace

TEST_CASE("verify: an archive of a whole world is whole, on any number of threads", "[archive]") {
    Archive archive;
    const auto file = archive.write();
    for (const int threads : {1, 3}) {
        for (const Verification& found : {verify(file, threads), verify_stored(file, threads)}) {
            CHECK(found.problems == 0);
            CHECK(found.first_problems.empty());
            CHECK(found.boxes == archive.boxes.size());
            CHECK(found.holes == 0);
        }
    }
}

TEST_CASE("verify: levels that do not fit each other are named", "[archive]") {
    struct Case {
        const char* name;
        std::function<void(Archive&)> change;
        std::string said;
    };
    const std::vector<Case> cases = {
        {"a parent is missing", [](Archive& a) { a.boxes.erase(a.first(1)); }, "is missing"},
        {"the top is missing", [](Archive& a) { a.boxes.erase(a.top()); }, "is missing"},
        {"a child is missing", [](Archive& a) { a.boxes.erase(a.first(0)); },
         "is not what its children give"},
        {"all children are missing",
         [](Archive& a) {
             const BoxKey parent = a.first(1);
             std::erase_if(a.boxes, [&](const auto& entry) {
                 const BoxKey& k = entry.first;
                 return k.level == 0 && voxel::floor_div(k.bx, 2) == parent.bx &&
                        voxel::floor_div(k.by, 2) == parent.by &&
                        voxel::floor_div(k.bz, 2) == parent.bz;
             });
         },
         "has nothing below it"},
        {"a child is a hole", [](Archive& a) { a.boxes[a.first(0)] = nullptr; },
         "but a child of it is a hole"},
        {"a hole has no reason", [](Archive& a) { a.boxes[a.first(1)] = nullptr; },
         "is a hole, but none of its children is"},
    };
    for (const Case& one : cases) {
        INFO(one.name);
        Archive archive;
        one.change(archive);
        const Verification found = verify(archive.write());
        CHECK(found.problems > 0);
        REQUIRE(!found.first_problems.empty());
        CHECK_THAT(found.first_problems.front(), contains(one.said));
    }
}

TEST_CASE("verify: a hole is one up to the top, and no problem", "[archive]") {
    Archive archive;
    BoxKey key = archive.first(0);
    for (; key.level < archive.levels();
         key = {key.level + 1, voxel::floor_div(key.bx, 2), voxel::floor_div(key.by, 2),
                voxel::floor_div(key.bz, 2)})
        archive.boxes[key] = nullptr;
    const auto file = archive.write();
    const Verification found = verify(file);
    CHECK(found.problems == 0);
    CHECK(found.holes == static_cast<std::uint64_t>(archive.levels()));
    CHECK(make_summary(file).holes() == found.holes);
}

TEST_CASE("verify: the summary counts what is there", "[archive]") {
    Archive archive;
    const auto file = archive.write();
    const Summary summary = make_summary(file);
    CHECK(summary.file_bytes == std::filesystem::file_size(file));
    REQUIRE(summary.levels.size() == static_cast<std::size_t>(archive.levels()));
    std::vector<std::uint64_t> counts(summary.levels.size());
    for (const auto& [key, box] : archive.boxes)
        ++counts[static_cast<std::size_t>(key.level)];
    for (std::size_t level = 0; level < counts.size(); ++level)
        CHECK(summary.levels[level].boxes == counts[level]);
    CHECK_THAT(to_text(summary), contains("EPSG:3794") && contains("nobody"));
}

TEST_CASE("verify: any byte that changes is found", "[archive]") {
    Archive archive;
    const auto file = archive.write();
    const std::string whole = read_content(file);
    const auto is_refused = [&](const std::string& bytes) {
        std::ofstream(file, std::ios::binary | std::ios::trunc) << bytes;
        const auto finds = [&](auto verifier) {
            try {
                return verifier(file, 1, VerifyProgress()).problems > 0;
            } catch (const util::Error&) {
                return true;
            }
        };
        const bool is_found = finds(verify);
        CHECK(finds(verify_stored) == is_found);
        return is_found;
    };
    CHECK(!is_refused(whole));
    std::mt19937 random(11);
    for (int i = 0; i < 150; ++i) {
        // A third of them in the header and the facts, a third at the end: the index.
        const std::size_t span = i % 3 == 0 ? 800 : i % 3 == 1 ? 300 : whole.size();
        const std::size_t at = i % 3 == 1 ? whole.size() - 1 - random() % span : random() % span;
        std::string changed = whole;
        changed[at] = static_cast<char>(changed[at] ^ (1 << random() % 8));
        INFO("byte " << at);
        // The facts have no checksum: a changed word may be as valid as before.
        if (is_refused(changed))
            continue;
        CHECK(at >= sizeof(voxel::archive::Header));
        CHECK(at < sizeof(voxel::archive::Header) + 700);
    }
    CHECK(is_refused(whole + "more"));
    for (const std::size_t bytes : {whole.size() - 1, whole.size() / 2, std::size_t{64}})
        CHECK(is_refused(whole.substr(0, bytes)));
}

TEST_CASE("verify: what is stored is verified in stretches, of any length", "[archive]") {
    const test::TemporaryFolder folder;
    const std::filesystem::path file = folder.path() / "a.tvx";
    voxel::WorldInfo info;
    info.bounds = {{0, 0, 0}, {100 * voxel::kBoxSizeX, 10, 50 * voxel::kBoxSizeZ}};
    info.levels = voxel::levels_for(info.bounds);
    std::vector<BoxKey> keys;
    for (std::int32_t bx = 0; bx < 100; ++bx)
        for (std::int32_t bz = 0; bz < 50; ++bz)
            keys.push_back({0, bx, 0, bz});
    std::shuffle(keys.begin(), keys.end(), std::mt19937(3));
    voxel::ArchiveWriter writer(file, info, 0);
    for (const BoxKey& key : keys) {
        const std::string frame = voxel::to_string(key);
        writer.add(key, key.bx == key.bz ? Kind::kHole : Kind::kBox,
                   std::as_bytes(std::span(frame)));
    }
    writer.finish();
    {
        const std::string last = voxel::to_string(keys.back());
        const std::size_t at = read_content(file).find(last);
        std::fstream(file, std::ios::in | std::ios::out).seekp(static_cast<std::streamoff>(at))
            << "x";
    }
    const ArchiveFiles archive(file);
    const auto source = archive.open();
    for (const std::size_t stretch : {std::size_t{1}, std::size_t{2000}, std::size_t{1} << 20}) {
        INFO(stretch);
        std::uint64_t done = 0;
        std::uint64_t total = 0;
        const Verification found = verify_open(
            *source, archive.bytes(), 2,
            [&](std::uint64_t now, std::uint64_t all) {
                CHECK(now > done);
                done = now;
                total = all;
            },
            stretch);
        CHECK(found.boxes == 4950);
        CHECK(found.holes == 50);
        CHECK(done == 5000);
        CHECK(total == 5000);
        REQUIRE(found.problems == 1);
        CHECK(found.first_problems[0] == "box " + voxel::to_string(keys.back()) + " is damaged");
    }
}
