#include "voxelserver/make/worlds/overlay/plane_world.hpp"

#include "common/voxel/pyramid_world.hpp"
#include "tests/catch.hpp"
#include "tests/common/voxel/array_world.hpp"
#include "tests/voxelserver/make/worlds/voxels.hpp"

namespace {

using namespace terravox;
using overlay::Plane;
using test::ArrayWorld;
using test::Voxels;
using voxel::Material;

/// Grass from y = -3 up to 5, with a hole in it, and a tower.
std::unique_ptr<ArrayWorld> meadow() {
    auto world = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-40, -3, -40},
                                              ArrayWorld::Coord{90, 300, 70});
    world->fill({-40, -3, -40}, {90, 5, 70}, Material::kGrass);
    world->fill({10, -3, 10}, {20, 5, 20}, Material::kAir);
    world->fill({40, 5, 40}, {44, 290, 44}, Material::kRoof);
    return world;
}

/// Grass from y = 6 to 8, 64 columns wide, on three levels: where voxels have an edge of 4, the
/// height of a plane beneath it is rounded to 8.
class Slab final : public voxel::World {
public:
    Slab() {
        m_info.bounds = {{0, 6, 0}, {64, 8, 64}};
        m_info.levels = 3;
    }
    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }
    [[nodiscard]] std::shared_ptr<const voxel::Box> box(const voxel::BoxKey& key) override {
        voxel::BoxBuilder builder;
        if (key.bx != 0 || key.by != 0 || key.bz != 0)
            return nullptr;
        for (int z = 0; z < 64 >> key.level; ++z)
            for (int x = 0; x < 64 >> key.level; ++x)
                builder.add(x, z, 6 >> key.level, (7 >> key.level) + 1, true);
        return builder.build(
            key, [](int, int, int) { return voxel::VoxelAttr{Material::kGrass, 0, 0, 0, {}, 0}; });
    }
    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        return voxel::column_of_bounds(m_info.bounds, level, bx, bz);
    }

private:
    voxel::WorldInfo m_info;
};

/// Whether a voxel of a place is hidden on a plane: opaque, as its six neighbours are. Those below
/// the place are the plane's.
bool is_hidden(const ArrayWorld& place, Plane plane, const ArrayWorld::Coord& at) {
    const auto opaque = [&](std::int32_t dx, std::int32_t dy, std::int32_t dz) {
        if (at[1] + dy < place.level_bounds().min[1])
            return plane == Plane::kTable;
        return !voxel::see_through(place.at(at[0] + dx, at[1] + dy, at[2] + dz));
    };
    return opaque(0, 0, 0) && opaque(-1, 0, 0) && opaque(1, 0, 0) && opaque(0, -1, 0) &&
           opaque(0, 1, 0) && opaque(0, 0, -1) && opaque(0, 0, 1);
}

/// How many voxels are hidden in the first box, and can be seen in the second.
int count_bared(const voxel::Box& before, const voxel::Box& after) {
    int out = 0;
    for (int z = 0; z < voxel::kBoxSizeZ; ++z)
        for (int x = 0; x < voxel::kBoxSizeX; ++x)
            for (int y = 0; y < voxel::kBoxSizeY; ++y)
                out += before.hidden(x, y, z) && !after.hidden(x, y, z) ? 1 : 0;
    return out;
}

/// Keys of all levels: around the place, and at the plane's edges.
std::vector<voxel::BoxKey> some_keys(const voxel::WorldInfo& info) {
    std::vector<voxel::BoxKey> out;
    for (int level = 0; level < info.levels; ++level)
        for (const std::int32_t by : {-2, -1, 0, 1, 2})
            for (const std::int32_t bx : {-5, -1, 0, 1})
                for (const std::int32_t bz : {-1, 0, 1, 7})
                    out.push_back({level, bx, by, bz});
    return out;
}

}  // namespace

TEST_CASE("a place lies on the plane as it was", "[voxelserver][overlay]") {
    const Plane plane = GENERATE(Plane::kTable, Plane::kSea);
    const Material material = plane == Plane::kSea ? Material::kWater : Material::kPlain;
    const auto world = overlay::on_plane(meadow(), plane);
    const auto alone = meadow();
    Voxels voxels(*world);
    Voxels before(*alone);
    // Hidden voxels are rock, and more are hidden where there is a plane beneath.
    const auto is_same = [&](std::int32_t x, std::int32_t y, std::int32_t z) {
        const Material there = voxels.material(x, y, z);
        return there == before.material(x, y, z) ||
               (there == Material::kRock && is_hidden(*alone, plane, {x, y, z}));
    };
    int differing = 0;
    for (std::int32_t y = -3; y < 300; y += y < 10 ? 1 : 7)
        for (std::int32_t z = -40; z < 70; ++z)
            for (std::int32_t x = -40; x < 90; ++x)
                differing += is_same(x, y, z) ? 0 : 1;
    CHECK(differing == 0);
    for (const auto& [x, z] : {std::pair{-41, 0}, {91, 3}, {5000, -90'000}, {15, 15}}) {
        INFO(x << " " << z);
        CHECK(voxels.material(x, -4, z) == material);
        CHECK(voxels.material(x, -3, z) == Material::kAir);
    }
}

TEST_CASE("what is hidden in a place stays so on the plane, next to other boxes too",
          "[voxelserver][overlay]") {
    const auto world = overlay::on_plane(meadow(), GENERATE(Plane::kTable, Plane::kSea));
    const auto alone = meadow();
    for (const voxel::BoxKey& key : {voxel::BoxKey{0, 0, -1, 0}, {0, 0, -1, -1}, {0, -1, -1, -1}}) {
        INFO(voxel::to_string(key));
        const auto before = alone->box(key);
        const auto after = world->box(key);
        REQUIRE((before && after));
        CHECK(before->hidden(30, 255, 30));
        CHECK_FALSE(before->hidden(30, 100, 30));
        CHECK(count_bared(*before, *after) == 0);
    }
}

TEST_CASE("a camera frames the place on the plane as it did before", "[voxelserver][overlay]") {
    const auto world = overlay::on_plane(meadow(), Plane::kTable);
    CHECK(world->info().camera_bounds() == meadow()->info().camera_bounds());
    CHECK(world->info().bounds.max[1] == meadow()->info().bounds.max[1]);
    CHECK(world->info().levels > 10);
    CHECK(world->edition() == "on a table");
    CHECK(overlay::on_plane(meadow(), Plane::kSea)->edition() == "in a sea");
}

TEST_CASE("on every level the plane is there, and the place on it", "[voxelserver][overlay]") {
    const auto world = overlay::on_plane(meadow(), Plane::kTable);
    for (int level = 0; level < world->info().levels; ++level) {
        INFO(level);
        Voxels voxels(*world, level);
        const std::int32_t side = std::int32_t{1} << level;
        // The plane's height is rounded.
        const std::int32_t top = voxel::floor_div(-3, side);
        CHECK((voxels.at(100'000 / side, top - 1, 0) || voxels.at(100'000 / side, top, 0)));
        CHECK_FALSE(voxels.at(100'000 / side, top + 1, 0));
        // The tower is four voxels wide.
        if (side <= 4)
            CHECK(voxels.at(42 / side, 100 / side, 42 / side));
    }
}

TEST_CASE("where the plane's height is rounded, the place wins", "[voxelserver][overlay]") {
    const auto world = overlay::on_plane(std::make_unique<Slab>(), Plane::kTable);
    for (const int level : {0, 1, 2}) {
        INFO(level);
        Voxels voxels(*world, level);
        CHECK(voxels.material(4, 7 >> level, 4) == Material::kGrass);
    }
}

TEST_CASE("extents of the plane hold all of its boxes", "[voxelserver][overlay]") {
    const auto world = overlay::on_plane(meadow(), Plane::kTable);
    int found = 0;
    const std::vector<voxel::BoxKey> keys = some_keys(world->info());
    std::map<voxel::BoxKey, std::shared_ptr<const voxel::Box>> batch;
    world->boxes(keys, [&](const voxel::BoxKey& key, const voxel::BoxOutcome& outcome) {
        CHECK_FALSE(outcome.failure);
        batch[key] = outcome.box;
    });
    for (const voxel::BoxKey& key : keys) {
        INFO(voxel::to_string(key));
        const auto box = world->box(key);
        REQUIRE(batch.contains(key));
        CHECK((box == nullptr) == (batch[key] == nullptr));
        if (!box)
            continue;
        ++found;
        CHECK(box->checksum() == batch[key]->checksum());
        const voxel::ColumnExtent extent = world->column(key.level, key.bx, key.bz);
        CHECK((key.by >= extent.by_begin && key.by < extent.by_end));
        CHECK(world->may_hold({key, {key.level, key.bx + 1, key.by + 1, key.bz + 1}}));
    }
    CHECK(found > 100);
}

TEST_CASE("a hole of the place is a hole on the plane", "[voxelserver][overlay]") {
    auto place = meadow();
    place->make_hole({0, 0, 0, 0});
    const auto world = overlay::on_plane(std::move(place), Plane::kTable);
    CHECK_THROWS(world->box({0, 0, 0, 0}));
    CHECK_NOTHROW(world->box({0, 9, -1, 9}));
}

TEST_CASE("a world without end, or without a voxel, needs no plane", "[voxelserver][overlay]") {
    auto endless = meadow();
    endless->editable_info().framed = endless->info().bounds;
    const voxel::World* const given = endless.get();
    CHECK(overlay::on_plane(std::move(endless), Plane::kSea).get() == given);
    auto empty = meadow();
    empty->editable_info().bounds = {};
    const voxel::World* const air = empty.get();
    CHECK(overlay::on_plane(std::move(empty), Plane::kSea).get() == air);
}
