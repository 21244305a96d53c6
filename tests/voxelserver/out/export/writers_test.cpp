// What the writers of all formats have in common. Worlds that are as wide as a file can say, and
// hold little or nothing: conversions look at what stands there, not at all the air; without that
// these tests would not end.
#include <algorithm>
#include <functional>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_reader.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "tests/voxelserver/out/export/shape/painted_world.hpp"
#include "voxelserver/out/export/anvil/write_anvil.hpp"
#include "voxelserver/out/export/archive/archive_export.hpp"
#include "voxelserver/out/export/core/job.hpp"
#include "voxelserver/out/export/mesh/mesh.hpp"
#include "voxelserver/out/export/vdb/vdb.hpp"
#include "voxelserver/out/export/vox/vox.hpp"

using namespace terravox;
using namespace terravox::exports;
using terravox::test::contains;
using voxel::BoxKey;
namespace fs = std::filesystem;

namespace {

constexpr std::int32_t kWide = 1 << 26;  // the farthest that an archive can say, voxels

voxel::WorldInfo wide_info(std::int32_t wide = kWide, std::int32_t high = 4096) {
    voxel::WorldInfo info;
    info.title = "wide";
    info.bounds = {{-wide, 0, -wide}, {wide, high, wide}};
    info.levels = voxel::levels_for(info.bounds);
    return info;
}

std::shared_ptr<const voxel::Box> one_voxel(const BoxKey& key) {
    voxel::BoxBuilder builder;
    builder.add(3, 5, 7, 8, true);
    return builder.build(key, [](int, int, int) {
        return voxel::VoxelAttr{voxel::Material::kGrass, 0, 0, 0, {}, 0};
    });
}

std::unique_ptr<voxel::World> make_archive(const fs::path& file, const voxel::WorldInfo& info,
                                           const std::vector<BoxKey>& keys) {
    voxel::ArchiveWriter writer(file, info, 0);
    for (const BoxKey& key : keys)
        writer.add(key, voxel::archive::Kind::kBox, voxel::compress(*one_voxel(key)));
    writer.finish();
    return voxel::open_archive(voxel::archive::file_source(file));
}

struct Writer {
    const char* name;
    std::function<void(Job&)> write;
    bool refuses_nothing;
};
const std::vector<Writer>& writers() {
    static const std::vector<Writer> all = {
        {"a.tvx", [](Job& job) { write_archive(job); }, false},
        {"a.vdb", [](Job& job) { write_vdb(job, {UpAxis::kZ}); }, true},
        {"a.vox", [](Job& job) { write_vox(job); }, true},
        {"a.glb", [](Job& job) { write_mesh(job, MeshFormat::kGlb, {}); }, true},
        {"a.ply", [](Job& job) { write_mesh(job, MeshFormat::kPly, {}); }, true},
        {"town", [](Job& job) { exports::anvil::write_anvil(job, {}); }, true},
    };
    return all;
}

/// @return voxels
std::uint64_t convert_to(const Writer& writer, voxel::World& world, const fs::path& folder) {
    static const voxel::Palette palette;
    const Part part = make_part(world.info(), {});
    Meter meter("test", 1, true);
    Job job(world, part, folder / writer.name, palette, meter);
    job.threads = 2;
    writer.write(job);
    CHECK(job.holes().empty());
    return job.voxels();
}

// A Minecraft world is at most 60 million blocks wide.
voxel::WorldInfo info_for(const Writer& writer) {
    return wide_info(std::string(writer.name) == "town" ? 29'000'000 : kWide,
                     std::string(writer.name) == "town" ? 256 : 4096);
}

}  // namespace

TEST_CASE("the bytes of a file depend neither on threads nor on memory", "[convert][writers]") {
    const auto world = test::lumps(13, 50);
    for (const Writer& writer : writers()) {
        if (std::string(writer.name).find('.') == std::string::npos)
            continue;  // a folder
        DYNAMIC_SECTION(writer.name) {
            std::string first;
            for (const int threads : {1, 1, 5}) {
                test::ExportJob e(*world, {{-33, -7, 2}, {66, 59, 71}}, writer.name);
                e.job.threads = threads;
                // Where it is scarce, there are several vdb files.
                if (threads == 5 && std::string(writer.name) != "a.vdb")
                    e.job.memory_bytes = 0;
                writer.write(e.job);
                if (first.empty())
                    first = test::read_content(e.job.out);
                CHECK((test::read_content(e.job.out) == first && !first.empty()));
            }
        }
    }
}

TEST_CASE("a box that cannot be loaded is air, and counted", "[convert][writers]") {
    const auto world = test::lumps(15, 0);
    world->make_hole({0, 0, 0, 0}, [] { throw util::Error("the disk is gone"); });
    for (const Writer& writer : writers()) {
        if (std::string(writer.name) == "a.tvx")
            continue;  // it keeps holes
        DYNAMIC_SECTION(writer.name) {
            test::ExportJob e(*world, writer.name);
            writer.write(e.job);
            CHECK(e.job.holes() == std::vector<BoxKey>{{0, 0, 0, 0}});
        }
    }
}

TEST_CASE("a wide archive of nothing is converted or refused, and no more", "[convert][wide]") {
    for (const Writer& writer : writers()) {
        DYNAMIC_SECTION(writer.name) {
            const test::TemporaryFolder folder;
            const auto world = make_archive(folder.path() / "from.tvx", info_for(writer), {});
            if (writer.refuses_nothing) {
                CHECK_THROWS_WITH(convert_to(writer, *world, folder.path()),
                                  contains("nothing solid"));
                CHECK(test::files_in(folder.path()) == std::set<std::string>{"from.tvx"});
            } else {
                CHECK(convert_to(writer, *world, folder.path()) == 0);
            }
        }
    }
}

TEST_CASE("a wide archive of little is converted to the little", "[convert][wide]") {
    for (const Writer& writer : writers()) {
        DYNAMIC_SECTION(writer.name) {
            const test::TemporaryFolder folder;
            const voxel::WorldInfo info = info_for(writer);
            const std::int32_t last = info.bounds.max[0] / 64 - 1;
            const std::int32_t first = info.bounds.min[0] / 64;
            const auto world = make_archive(
                folder.path() / "from.tvx", info,
                {{0, first, 0, first}, {0, 0, 0, 0}, {0, last, 0, last}, {0, 7, 0, 9}});
            CHECK(convert_to(writer, *world, folder.path()) == 4);
            if (std::string(writer.name) != "a.tvx")
                return;
            const auto copy =
                voxel::open_archive(voxel::archive::file_source(folder.path() / "a.tvx"));
            CHECK(copy->info().bounds == info.bounds);
            for (const BoxKey& key : {BoxKey{0, first, 0, first}, BoxKey{0, last, 0, last}})
                CHECK(copy->box(key)->checksum() == one_voxel(key)->checksum());
        }
    }
}

TEST_CASE("what is not known to be air is limited", "[convert][wide]") {
    class Unknown final : public voxel::World {
    public:
        [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
        [[nodiscard]] std::shared_ptr<const voxel::Box> box(const BoxKey&) override {
            return nullptr;
        }
        [[nodiscard]] voxel::ColumnExtent column(int, std::int32_t, std::int32_t) override {
            return {0, 1};
        }

    private:
        const voxel::WorldInfo m_info = wide_info(kWide / 4, 200);
    } world;
    // A file and a folder; the other files go by the same columns.
    for (const Writer& writer : {writers().front(), writers().back()}) {
        DYNAMIC_SECTION(writer.name) {
            const test::TemporaryFolder folder;
            CHECK_THROWS_AS(convert_to(writer, world, folder.path()), util::UsageError);
            CHECK(fs::is_empty(folder.path()));
        }
    }
}

TEST_CASE("a part that is higher than anything stands is refused", "[convert][wide]") {
    const voxel::WorldInfo info = wide_info(64, 4096 * 256 + 1);
    CHECK_THROWS_WITH(make_part(info, {}), contains("4097 boxes") && contains("4096"));
    Selection low;
    Selection coarse;
    low.heights = {0, 4096 * 256};
    coarse.level = 1;
    CHECK_NOTHROW(make_part(info, low));
    CHECK_NOTHROW(make_part(info, coarse));
}

TEST_CASE("an archive reports where its boxes may lie", "[convert][wide]") {
    const test::TemporaryFolder folder;
    std::vector<BoxKey> keys;
    for (std::int32_t i = 0; i < 3000; ++i)
        keys.push_back({i % 3, i * 37 % 2000 - 1000, i * 11 % (16 >> i % 3), i * 71 % 2000 - 1000});
    std::sort(keys.begin(), keys.end());
    keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    const auto world = make_archive(folder.path() / "a.tvx", wide_info(), keys);
    std::uint32_t state = 1;
    const auto random = [&](int count) {
        return static_cast<std::int32_t>((state = state * 1664525 + 1013904223) >> 8) % count;
    };
    int some = 0;
    int none = 0;
    for (int n = 0; n < 4000; ++n) {
        const int level = random(4);
        const int wide = 1 << random(11);
        const BoxKey min{level, random(2400) - 1200, random(16), random(2400) - 1200};
        const voxel::BoxRange range{
            min,
            {level, min.bx + 1 + random(wide), min.by + 1 + random(16), min.bz + 1 + random(wide)}};
        const bool holds = std::any_of(keys.begin(), keys.end(), [&](const BoxKey& k) {
            return k.level == level && range.contains(k);
        });
        INFO(voxel::to_string(range.min) << " to " << voxel::to_string(range.max));
        CHECK(world->may_hold(range) == holds);
        ++(holds ? some : none);
    }
    CHECK(some > 300);
    CHECK(none > 300);
    CHECK_FALSE(world->may_hold({{20, 0, 0, 0}, {20, 1, 1, 1}}));
}
