#include "voxelserver/out/archive/patch.hpp"

#include <functional>
#include <random>
#include <set>

#include "common/util/error.hpp"
#include "common/voxel/archive/archive_parts.hpp"
#include "common/voxel/archive/archive_writer.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "tests/catch.hpp"
#include "tests/common/content.hpp"
#include "tests/common/temporary_folder.hpp"
#include "voxelserver/out/archive/verify.hpp"
#include "voxelserver/out/export/archive/archive_export.hpp"

using namespace terravox;
using terravox::test::contains;
using terravox::test::read_content;

namespace {

/// Blocks whose height and material hang on the column of boxes.
class Blocks final : public voxel::PyramidWorld {
public:
    /// @param make_seed a column of boxes; 0: nothing is there
    using MakeSeed = std::function<std::uint32_t(std::int32_t bx, std::int32_t bz)>;

    Blocks(const voxel::VoxelBounds& bounds, MakeSeed make_seed)
        : PyramidWorld(std::size_t{64} << 20), m_make_seed(std::move(make_seed)) {
        m_info.title = "blocks";
        m_info.bounds = bounds;
        m_info.levels = voxel::levels_for(bounds);
    }
    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }

protected:
    [[nodiscard]] voxel::FineColumn make_column(std::int32_t bx, std::int32_t bz) override {
        voxel::FineColumn out;
        const std::uint32_t seed = m_make_seed(bx, bz);
        if (seed == kDamaged)
            throw util::Error("read the square: it is damaged");
        voxel::BoxBuilder builder;
        const int height = 20 + static_cast<int>(seed % 60);
        if (seed != 0)
            for (int x = 0; x < voxel::kBoxSizeX; ++x)
                for (int z = 0; z < voxel::kBoxSizeZ; ++z)
                    builder.add(x, z, 0, height, true);
        voxel::VoxelAttr attr;
        attr.material = seed % 2 == 0 ? voxel::Material::kGrass : voxel::Material::kRock;
        out.boxes.push_back(builder.build({0, bx, 0, bz}, [&](int, int, int) { return attr; }));
        return out;
    }

public:
    static constexpr std::uint32_t kDamaged = 1'000'000;

private:
    const MakeSeed m_make_seed;
    voxel::WorldInfo m_info;
};

class Place {
public:
    std::filesystem::path convert(voxel::World& world, const char* name) {
        return with_job(world, name, [](exports::Job& job) { exports::write_archive(job); });
    }
    std::filesystem::path change(voxel::World& world, const exports::ChangedColumns& columns,
                                 const char* name = "change.tvx") {
        return with_job(world, name,
                        [&](exports::Job& job) { exports::write_change(job, columns); });
    }
    [[nodiscard]] std::filesystem::path file(const char* name) const {
        return m_folder.path() / name;
    }

private:
    std::filesystem::path with_job(voxel::World& world, const char* name,
                                   const std::function<void(exports::Job&)>& write) {
        const exports::Part part = exports::make_part(world.info(), {});
        const voxel::Palette palette;
        exports::Meter silent("", 0, true);
        exports::Job job(world, part, file(name), palette, silent);
        write(job);
        return file(name);
    }
    test::TemporaryFolder m_folder;
};

std::uint32_t seed_at(std::uint32_t salt, std::int32_t bx, std::int32_t bz) {
    std::mt19937 random(salt + static_cast<std::uint32_t>(bx * 7919 + bz * 104729));
    const std::uint32_t seed = random() % 400;
    return seed < 80 ? 0 : seed;
}

/// Patches archives of random worlds in which random columns change, and whose bounds may.
/// @param first_seed, end_seed half-open
void check_patches(std::uint32_t first_seed, std::uint32_t end_seed) {
    struct Case {
        const char* name;
        voxel::VoxelBounds before;
        voxel::VoxelBounds after;
    };
    const voxel::VoxelBounds small{{-100, 0, -130}, {150, 200, 90}};
    const voxel::VoxelBounds wide{{-700, 0, -200}, {800, 100, 300}};
    const std::vector<Case> cases = {
        {"small", small, small},
        {"with levels above those of subtrees", wide, wide},
        {"grown by a level", small, {{-100, 0, -130}, {450, 200, 90}}},
        {"grown by levels above those of subtrees", small, wide},
        {"shrunk", wide, {{-700, 0, -200}, {400, 100, 300}}},
        {"shrunk to within a coarse box", wide, {{-700, 0, -200}, {800, 100, 190}}},
    };
    for (const Case& one : cases)
        for (std::uint32_t seed = first_seed; seed < end_seed; ++seed) {
            INFO(one.name << ", seed " << seed);
            std::mt19937 random(seed);
            std::set<std::pair<std::int32_t, std::int32_t>> changed;
            exports::ChangedColumns columns;
            const voxel::BoxRange all = voxel::boxes_over(one.after, 0);
            const voxel::BoxRange old = voxel::boxes_over(one.before, 0);
            for (std::int32_t bz = all.min.bz; bz < all.max.bz; ++bz)
                for (std::int32_t bx = all.min.bx; bx < all.max.bx; ++bx) {
                    const bool is_new = !old.contains({0, bx, 0, bz});
                    if (is_new || random() % 10 == 0) {
                        changed.emplace(bx, bz);
                        columns.replaced.push_back({bx, bz});
                    } else if (random() % 10 == 0) {
                        columns.compared.push_back({bx, bz});
                    }
                }
            if (columns.replaced.empty() || columns.compared.empty())
                continue;
            Blocks before(one.before,
                          [&](std::int32_t bx, std::int32_t bz) { return seed_at(seed, bx, bz); });
            Blocks after(one.after, [&](std::int32_t bx, std::int32_t bz) {
                return seed_at(changed.contains({bx, bz}) ? seed + 100 : seed, bx, bz);
            });
            Place place;
            const auto archive = place.convert(before, "old.tvx");
            const auto wanted = place.convert(after, "new.tvx");
            const auto change = place.change(after, columns);
            CHECK(archive_tools::verify(change).problems == 0);
            const std::vector changes{change};
            const archive_tools::PatchReport report =
                archive_tools::patch(archive, changes, place.file("patched.tvx"), 2);
            CHECK(report.columns == columns.replaced.size());
            CHECK((read_content(place.file("patched.tvx")) == read_content(wanted)));
            (void)archive_tools::patch(archive, changes, archive, 1);
            CHECK((read_content(archive) == read_content(wanted)));
        }
}

}  // namespace

TEST_CASE("patch: a patched archive is that of the changed world", "[archive]") {
    check_patches(1, 2);
}

TEST_CASE("patch: any patched archive is that of the changed world", "[archive][all]") {
    check_patches(2, 7);
}

TEST_CASE("patch: a square that was damaged is mended, holes and all", "[archive]") {
    const voxel::VoxelBounds bounds{{-100, 0, -130}, {900, 200, 90}};
    Blocks before(bounds, [](std::int32_t bx, std::int32_t bz) {
        return bx == 3 && bz == 0 ? Blocks::kDamaged : seed_at(5, bx, bz);
    });
    Blocks after(bounds, [](std::int32_t bx, std::int32_t bz) { return seed_at(5, bx, bz); });
    Place place;
    const auto archive = place.convert(before, "old.tvx");
    const auto wanted = place.convert(after, "new.tvx");
    const std::vector mended{place.change(after, {{{3, 0}}, {{2, 0}, {4, 0}}}, "mended.tvx")};
    const std::vector broken{place.change(before, {{{3, 0}}, {{2, 0}, {4, 0}}}, "broken.tvx")};
    const std::string damaged = read_content(archive);
    CHECK(archive_tools::patch(archive, mended, archive).holes == 0);
    CHECK((read_content(archive) == read_content(wanted)));
    CHECK(archive_tools::patch(archive, broken, archive).holes > 0);
    CHECK((read_content(archive) == damaged));
}

TEST_CASE("patch: what does not belong together is refused, and nothing is written", "[archive]") {
    const voxel::VoxelBounds bounds{{-100, 0, -130}, {150, 200, 90}};
    const auto world = [&](std::uint32_t salt) {
        return Blocks(
            bounds, [salt](std::int32_t bx, std::int32_t bz) { return 1 + seed_at(salt, bx, bz); });
    };
    Place place;
    Blocks here = world(5);
    Blocks elsewhere = world(6);
    const auto archive = place.convert(here, "old.tvx");
    const auto out = place.file("patched.tvx");
    const auto refused = [&](const std::filesystem::path& change) {
        const std::vector changes{change};
        try {
            (void)archive_tools::patch(archive, changes, out);
        } catch (const util::UsageError& e) {
            CHECK(!std::filesystem::exists(out));
            CHECK(!std::filesystem::exists(out.string() + ".part"));
            return std::string(e.what());
        }
        return std::string("done");
    };
    CHECK_THAT(refused(place.change(elsewhere, {{{0, 0}}, {{1, 0}}})), contains("are not alike"));
    CHECK_THAT(refused(archive), contains("not a change"));
    CHECK_THAT(refused(place.change(here, {{{0, 0}}, {}})), contains("no boxes to compare"));
    CHECK(refused(place.change(here, {{{0, 0}}, {{1, 0}}})) == "done");
}

TEST_CASE("patch: a change of all columns belongs to any archive of the same frame", "[archive]") {
    const voxel::VoxelBounds bounds{{-100, 0, -130}, {150, 200, 90}};
    Place place;
    Blocks before(bounds, [](std::int32_t bx, std::int32_t bz) { return seed_at(5, bx, bz); });
    Blocks after(bounds, [](std::int32_t bx, std::int32_t bz) { return seed_at(6, bx, bz); });
    const auto archive = place.convert(before, "old.tvx");
    const auto wanted = place.convert(after, "new.tvx");
    const voxel::BoxRange all = voxel::boxes_over(bounds, 0);
    exports::ChangedColumns columns;
    for (std::int32_t bz = all.min.bz; bz < all.max.bz; ++bz)
        for (std::int32_t bx = all.min.bx; bx < all.max.bx; ++bx)
            columns.replaced.push_back({bx, bz});
    const std::vector changes{place.change(after, columns)};
    CHECK(archive_tools::patch(archive, changes, archive).kept == 0);
    CHECK((read_content(archive) == read_content(wanted)));
}

TEST_CASE("patch: changes are compared with each other where they meet", "[archive]") {
    const voxel::VoxelBounds bounds{{-100, 0, -130}, {450, 200, 90}};
    const auto world = [&](std::uint32_t salt) {
        return Blocks(
            bounds, [salt](std::int32_t bx, std::int32_t bz) { return 1 + seed_at(salt, bx, bz); });
    };
    Place place;
    Blocks here = world(5);
    Blocks elsewhere = world(6);
    const auto archive = place.convert(here, "old.tvx");
    const auto first = place.change(here, {{{2, 0}, {0, 0}}, {{3, 0}}}, "first.tvx");
    const exports::ChangedColumns between{{{1, 0}}, {{0, 0}, {2, 0}}};
    const std::vector alike{first, place.change(here, between, "alike.tvx")};
    const std::vector other{first, place.change(elsewhere, between, "other.tvx")};
    CHECK(archive_tools::patch(archive, alike, place.file("patched.tvx")).columns == 3);
    CHECK_THROWS_WITH(archive_tools::patch(archive, other, place.file("patched.tvx")),
                      contains("are not alike"));
}
