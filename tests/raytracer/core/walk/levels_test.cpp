// Walks through boxes of several levels, and tests the answers of beams for them.
#include <random>

#include "raytracer/core/base/random.hpp"
#include "raytracer/core/scene/camera.hpp"
#include "raytracer/core/walk/beam.hpp"
#include "raytracer/core/walk/surroundings.hpp"
#include "raytracer/core/walk/walk.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/pyramid_world.hpp"

using namespace terravox;
using terravox::test::ArrayWorld;
using terravox::test::PyramidWorld;
using voxel::Material;

namespace {

constexpr std::size_t kPlenty = std::size_t{1} << 30;
constexpr int kLevels = 4;
using Random = std::mt19937_64;
double real(Random& r, double low, double high) {
    return low + core::unit_from(r()) * (high - low);
}

/// Hills with towers and floating stones over some twenty columns of boxes. They take long to make.
PyramidWorld& hills() {
    static const std::unique_ptr<PyramidWorld> world = [] {
        auto finest = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-150, -20, -140},
                                                   ArrayWorld::Coord{170, 90, 150});
        finest->fill_with([](int x, int y, int z) {
            const int height = static_cast<int>(core::hash64(static_cast<std::uint64_t>(x >> 3),
                                                             static_cast<std::uint64_t>(z >> 3)) %
                                                9) +
                               (x * x + z * z) / 1500;
            if (y < height)
                return Material::kGround;
            const auto h = core::hash64(
                static_cast<std::uint64_t>(x >> 2) << 32 ^ static_cast<std::uint32_t>(z >> 2),
                static_cast<std::uint64_t>(y >> 4));
            if (h % 61 == 0 && y < 60)
                return Material::kWall;
            return y > 60 && h % 97 == 1 ? Material::kRoof : Material::kAir;
        });
        return std::make_unique<PyramidWorld>(std::move(finest), kLevels);
    }();
    return *world;
}

/// What is missing would stop beams early and prove nothing.
void load_all(blocks::BlockManager& blocks, const voxel::WorldInfo& info) {
    for (int level = 0; level < kLevels; ++level) {
        const auto range = voxel::boxes_over(info.bounds, level);
        for (auto key = range.min; key.bx < range.max.bx; ++key.bx)
            for (key.bz = range.min.bz; key.bz < range.max.bz; ++key.bz)
                for (key.by = range.min.by; key.by < range.max.by; ++key.by)
                    (void)blocks.get(key);
    }
}

struct Fixture {
    explicit Fixture(core::Vec3 eye, double detail = 1, double pixel_rad = 0.03)
        : cut(world.info().bounds, eye, pixel_rad, detail, 0, kLevels - 1),
          blocks(world, kPlenty),
          reader(blocks),
          walker(reader, cut) {}
    PyramidWorld& world = hills();
    walk::LevelCut cut;
    blocks::BlockManager blocks;
    walk::BlockReader reader;
    walk::Walker walker;

    /// Whether a level-0 voxel is solid in the boxes of the cut, and the level that decides it.
    [[nodiscard]] bool solid(const std::int32_t (&v)[3], int& level) const {
        level = cut.level_at(v[0], v[2], 0);
        return world.at(level, v[0] >> level, v[1] >> level, v[2] >> level) != Material::kAir;
    }

    /// Single steps over level-0 voxels.
    [[nodiscard]] std::optional<walk::Hit> reference(const core::Ray& ray) const {
        const voxel::VoxelBounds& b = cut.entry_bounds();
        core::RayState s(ray);
        if (!s.enter(b))
            return std::nullopt;
        while (true) {
            for (int a = 0; a < 3; ++a)
                if (s.voxel[a] < b.min[static_cast<std::size_t>(a)] ||
                    s.voxel[a] >= b.max[static_cast<std::size_t>(a)])
                    return std::nullopt;
            int level = 0;
            if (solid(s.voxel, level)) {
                walk::Hit hit;
                hit.t = s.t;
                hit.face = s.face;
                hit.level = static_cast<std::int8_t>(level);
                hit.voxel = {s.voxel[0] >> level, s.voxel[1] >> level, s.voxel[2] >> level};
                return hit;
            }
            s.leap(0);
        }
    }
};

bool same(const std::optional<walk::Hit>& a, const std::optional<walk::Hit>& b) {
    if (a.has_value() != b.has_value())
        return false;
    return !a ||
           (a->t == b->t && a->voxel == b->voxel && a->face == b->face && a->level == b->level);
}

const core::Vec3 kEyes[] = {{-130.5, 70.5, -120.25}, {-400.125, 200, 30}, {0, 500, 0}};

}  // namespace

TEST_CASE(
    "the level of a column does not depend on where the search begins, and grows with the distance",
    "[raytracer][levels]") {
    const voxel::VoxelBounds bounds{{-5000, 0, -5000}, {5000, 300, 5000}};
    const walk::LevelCut cut(bounds, {100, 50, -300}, 0.01, 1, 0, 6);
    Random random(5);
    for (int i = 0; i < 5000; ++i) {
        const auto x = static_cast<std::int32_t>(real(random, -6000, 6000));
        const auto z = static_cast<std::int32_t>(real(random, -6000, 6000));
        const int level = cut.level_at(x, z, 0);
        for (int hint = -1; hint < 9; ++hint)
            REQUIRE(cut.level_at(x, z, hint) == level);
        // No voxel is wider than a pixel there; and the next level would have some that are.
        const double side = 64.0 * (1 << level);
        const double x0 = std::floor(x / side) * side;
        const double z0 = std::floor(z / side) * side;
        const double dx = std::max({x0 - 100, 100 - x0 - side, 0.0});
        const double dz = std::max({z0 + 300, -300 - z0 - side, 0.0});
        if (level > 0)
            REQUIRE((1 << level) <= 0.01 * std::sqrt(dx * dx + dz * dz) + 1e-9);
        if (level < 6)
            REQUIRE_FALSE(cut.far_enough(level + 1, x >> (7 + level), z >> (7 + level)));
    }
    const walk::LevelCut whole(bounds, {100, 50, -300}, 0.01, 0, 2, 6);
    CHECK(whole.level_at(4000, 4000, 6) == 2);
}

TEST_CASE("across levels the walker finds what single steps find", "[raytracer][levels]") {
    for (const core::Vec3& eye : kEyes) {
        DYNAMIC_SECTION("eye " << eye.x) {
            Fixture f(eye);
            Random random(11);
            std::array<int, kLevels> met{};
            int wrong = 0;
            for (int i = 0; i < 4000; ++i) {
                core::Ray ray{eye, core::normalized({real(random, -1, 1), real(random, -1, 0.4),
                                                     real(random, -1, 1)})};
                if (i % 3 == 0)
                    ray.origin = {real(random, -200, 200), real(random, 60, 120),
                                  real(random, -200, 200)};
                const auto found = f.walker.first_hit(ray);
                const auto wanted = f.reference(ray);
                if (wanted)
                    ++met[static_cast<std::size_t>(wanted->level)];
                if (!same(found, wanted) && ++wrong < 4)
                    FAIL_CHECK("ray " << i << ": t " << (found ? found->t : -1) << ", wanted "
                                      << (wanted ? wanted->t : -1));
            }
            CHECK(wrong == 0);
            if (eye.x == -130.5)
                for (int level = 0; level < 3; ++level)
                    CHECK(met[static_cast<std::size_t>(level)] > 50);
        }
    }
}

TEST_CASE("beams from eyes among towers, above and outside the world skip only empty space",
          "[raytracer][levels][beam]") {
    PyramidWorld& world = hills();
    blocks::BlockManager blocks(world, kPlenty);
    load_all(blocks, world.info());
    for (const double detail : {0.0, 1.0, 4.0, 20.0}) {
        INFO("detail " << detail);
        Random random(9);
        int wrong = 0;
        int rays = 0;
        int planes = 0;
        int misses = 0;
        for (int cameras = 0; cameras < 24;) {
            const bool near = cameras % 2 == 0;
            const core::Vec3 eye = near ? core::Vec3{real(random, -140, 160), real(random, 4, 60),
                                                     real(random, -130, 140)}
                                        : core::Vec3{real(random, -900, 900), real(random, 20, 300),
                                                     real(random, -900, 900)};
            if (near && world.at(0, core::RayState::floor_to_int(eye.x),
                                 core::RayState::floor_to_int(eye.y),
                                 core::RayState::floor_to_int(eye.z)) != Material::kAir)
                continue;
            ++cameras;
            const walk::LevelCut cut(world.info().bounds, eye, 0.01, detail, 0, kLevels - 1);
            walk::BlockReader reader(blocks);
            walk::RayWalk walk(reader, cut);
            walk::BeamMarch beams(reader, cut);
            const scene::Camera camera(
                eye, {real(random, -140, 160), real(random, 0, 60), real(random, -130, 140)},
                real(random, 20, 150), 64, 48);
            for (const int size : {16, 4})
                for (int y = 0; y < 48; y += size)
                    for (int x = 0; x < 64; x += size) {
                        const core::Vec3 corners[4] = {camera.ray(x, y).direction,
                                                       camera.ray(x + size, y).direction,
                                                       camera.ray(x, y + size).direction,
                                                       camera.ray(x + size, y + size).direction};
                        walk::Beam beam;
                        if (!walk::Beam::make(eye, corners, beam))
                            continue;
                        const walk::BeamStart start = beams.march(beam, {});
                        planes += start.kind == walk::BeamStart::Kind::kPlane ? 1 : 0;
                        misses += start.kind == walk::BeamStart::Kind::kMiss ? 1 : 0;
                        for (int i = 0; i < size * size; ++i) {
                            const core::Ray ray =
                                camera.ray(x + i % size + 0.37, y + i / size + 0.81);
                            core::RayState spared(ray), whole(ray);
                            walk::Hit a;
                            walk::Hit b;
                            const bool hit = start.place(spared, cut) &&
                                             walk.first_hit(spared, walk::StopAt::kSolid,
                                                            core::kFar, a) == walk::WalkEnd::kHit;
                            const bool wanted =
                                whole.enter(cut.entry_bounds()) &&
                                walk.first_hit(whole, walk::StopAt::kSolid, core::kFar, b) ==
                                    walk::WalkEnd::kHit;
                            ++rays;
                            if (!same(hit ? std::optional(a) : std::nullopt,
                                      wanted ? std::optional(b) : std::nullopt))
                                ++wrong;
                        }
                    }
        }
        CHECK(wrong == 0);
        CHECK(rays > 50'000);
        CHECK(planes > 500);
        CHECK(misses > 10);
    }
}

TEST_CASE("an occluder that is remembered changes no answer", "[raytracer][levels]") {
    Fixture f(kEyes[0]);
    walk::RayWalk walk(f.reader, f.cut);
    Random random(21);
    walk::Occluder occluder;
    int stopped = 0;
    for (int i = 0; i < 6000; ++i) {
        const core::Ray ray{
            {real(random, -140, 160), real(random, 20, 85), real(random, -130, 140)},
            core::normalized({0.4, 0.3 + 0.001 * (i % 7), -0.2})};
        core::RayState state(ray);
        REQUIRE(state.enter(f.cut.entry_bounds()));
        const bool wanted = f.walker.first_hit(ray).has_value();
        REQUIRE((walk.any_hit(state, core::kFar, occluder) == walk::WalkEnd::kHit) == wanted);
        stopped += wanted ? 1 : 0;
    }
    CHECK(stopped > 500);
}

TEST_CASE("the eight voxels around a face are those that are found one by one",
          "[raytracer][levels]") {
    Fixture f(kEyes[0]);
    walk::Surroundings surroundings(f.reader, f.cut);
    Random random(4);
    const auto now = [&](const auto& look) {
        while (!look())
            (void)f.blocks.get(surroundings.missing());
    };
    std::vector<walk::Hit> hits(6000);
    for (std::size_t i = 0; i < hits.size(); ++i) {
        walk::Hit& hit = hits[i];
        hit.voxel = {static_cast<std::int32_t>(real(random, -150, 170)),
                     static_cast<std::int32_t>(real(random, -20, 90)),
                     static_cast<std::int32_t>(real(random, -140, 150))};
        hit.face = static_cast<core::Face>(i % 6);
        hit.level = static_cast<std::int8_t>(i % 3);
        for (std::int32_t* c : {&hit.voxel.x, &hit.voxel.y, &hit.voxel.z})
            *c >>= hit.level;
    }
    // Again, because answers are kept.
    hits.insert(hits.end(), hits.begin(), hits.end());
    int mixed = 0;
    for (const walk::Hit& hit : hits) {
        walk::Seen seen;
        now([&] { return surroundings.around(hit, seen); });
        unsigned wanted = 0;
        for (int k = 0; k < 8; ++k) {
            const int place = k < 4 ? k : k + 1;
            const core::VoxelCoord front = walk::neighbour(hit.voxel, hit.face);
            std::int32_t c[3] = {front.x, front.y, front.z};
            const int axis = core::to_axis(hit.face);
            c[(axis + 1) % 3] += place / 3 - 1;
            c[(axis + 2) % 3] += place % 3 - 1;
            bool solid = false;
            now([&] { return surroundings.look({c[0], c[1], c[2]}, hit.level, solid); });
            wanted |= static_cast<unsigned>(solid) << k;
        }
        REQUIRE(seen.looked == 8);
        REQUIRE(seen.bits == wanted);
        mixed += wanted != 0 && wanted != 255 ? 1 : 0;
    }
    CHECK(mixed > 100);
}
