#include "raytracer/core/walk/walk.hpp"

#include <cstdio>
#include <random>
#include <string>

#include "raytracer/core/base/random.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/core/walk/reference_walker.hpp"

using namespace terravox;
using terravox::test::ArrayWorld;
using terravox::test::reference_hit;
using voxel::Material;

namespace {

constexpr std::size_t kPlenty = std::size_t{1} << 30;
constexpr int kMaxFailuresShown = 4;

std::string to_text(const std::optional<walk::Hit>& hit) {
    if (!hit)
        return "nothing";
    char out[200];
    std::snprintf(out, sizeof out, "t %a (%.17g) voxel (%d, %d, %d) face %d material %d%s", hit->t,
                  hit->t, hit->voxel.x, hit->voxel.y, hit->voxel.z, static_cast<int>(hit->face),
                  static_cast<int>(hit->attr.material), hit->hole ? " hole" : "");
    return out;
}

std::string to_text(const core::Ray& r) {
    char out[300];
    std::snprintf(out, sizeof out, "origin (%.17g, %.17g, %.17g) direction (%.17g, %.17g, %.17g)",
                  r.origin.x, r.origin.y, r.origin.z, r.direction.x, r.direction.y, r.direction.z);
    return out;
}

bool same(const std::optional<walk::Hit>& a, const std::optional<walk::Hit>& b) {
    if (a.has_value() != b.has_value())
        return false;
    return !a || (a->t == b->t && a->voxel == b->voxel && a->face == b->face &&
                  a->level == b->level && a->attr == b->attr && a->hole == b->hole);
}

/// A walker and the reference walker over one world.
class Pair {
public:
    explicit Pair(ArrayWorld& world, int level = 0)
        : m_world(world),
          m_blocks(world, kPlenty),
          m_reader(m_blocks),
          m_cut(world.info().bounds, level),
          m_walker(m_reader, m_cut) {}

    /// @param ray in voxels of the world's level
    void check(const core::Ray& ray, walk::StopAt stop = walk::StopAt::kSolid,
               double t_max = core::kFar) {
        const double scale = 1 << m_cut.finest();
        compare(m_walker.first_hit({ray.origin * scale, ray.direction * scale}, stop, t_max), ray,
                std::nullopt, stop, t_max);
    }
    void check_from(const core::Ray& ray, core::VoxelCoord start,
                    walk::StopAt stop = walk::StopAt::kSolid, double t_max = core::kFar) {
        compare(m_walker.first_hit_from(ray, start, 0, stop, t_max), ray, start, stop, t_max);
    }
    std::optional<walk::Hit> hit(const core::Ray& ray, walk::StopAt stop = walk::StopAt::kSolid) {
        return m_walker.first_hit(ray, stop);
    }
    walk::Walker& walker() { return m_walker; }
    [[nodiscard]] int rays() const { return m_rays; }
    [[nodiscard]] int hits() const { return m_hits; }
    [[nodiscard]] int holes() const { return m_holes; }
    [[nodiscard]] int differences() const { return m_differences; }

private:
    void compare(const std::optional<walk::Hit>& found, const core::Ray& ray,
                 const std::optional<core::VoxelCoord>& start, walk::StopAt stop, double t_max) {
        const auto wanted = reference_hit(m_world, ray, start, stop, t_max);
        ++m_rays;
        m_hits += wanted ? 1 : 0;
        m_holes += wanted && wanted->hole ? 1 : 0;
        if (same(found, wanted))
            return;
        if (++m_differences <= kMaxFailuresShown) {
            std::string at;
            if (start)
                at = " start (" + std::to_string(start->x) + ", " + std::to_string(start->y) +
                     ", " + std::to_string(start->z) + ")";
            FAIL_CHECK(to_text(ray) << at
                                    << (stop == walk::StopAt::kSolid ? ""
                                        : stop.air_stops             ? " within a medium"
                                                                     : " through water")
                                    << " t_max " << t_max << "\n  walker:    " << to_text(found)
                                    << "\n  reference: " << to_text(wanted));
        }
    }
    ArrayWorld& m_world;
    blocks::BlockManager m_blocks;
    walk::BlockReader m_reader;
    walk::LevelCut m_cut;
    walk::Walker m_walker;
    int m_rays = 0;
    int m_hits = 0;
    int m_holes = 0;
    int m_differences = 0;
};

/// Content as a function of the place, so that a world can be cut anywhere.
Material noise(std::uint64_t seed, std::int32_t x, std::int32_t y, std::int32_t z,
               unsigned one_in) {
    const auto h = core::hash64(seed ^ static_cast<std::uint32_t>(x) ^
                                    static_cast<std::uint64_t>(static_cast<std::uint32_t>(z)) << 32,
                                static_cast<std::uint32_t>(y));
    if (h % one_in != 0)
        return Material::kAir;
    constexpr std::array kSome = {Material::kRoof,           Material::kWater, Material::kWall,
                                  Material::kHighVegetation, Material::kRock,  Material::kRoad};
    return kSome[(h >> 40) % kSome.size()];
}

struct WorldCase {
    const char* name;
    ArrayWorld::Coord min;
    ArrayWorld::Coord max;
    void (*fill)(ArrayWorld&);
};

const WorldCase kWorlds[] = {
    {"sparse, over eight boxes and the origin",
     {-70, -40, -66},
     {75, 300, 61},
     [](ArrayWorld& w) {
         w.fill_with([](int x, int y, int z) { return noise(1, x, y, z, 3'000); });
     }},
    {"dense",
     {-20, 230, -20},
     {90, 290, 70},
     [](ArrayWorld& w) { w.fill_with([](int x, int y, int z) { return noise(2, x, y, z, 3); }); }},
    {"hills with solid bricks beneath, water in the valleys",
     {-64, -128, -64},
     {128, 128, 64},
     [](ArrayWorld& w) {
         w.fill_with([](int x, int y, int z) {
             const int height = static_cast<int>(((x * 7) ^ (z * 3)) & 15) -
                                ((x + 64) * (x - 128) + (z + 64) * (z - 64)) / 400;
             return y < height ? Material::kGround
                    : y < 12   ? Material::kWater
                               : noise(3, x, y, z, 4'000);
         });
     }},
    {"a deep lake with floating ice, over a bed of sand and stones",
     {0, 0, 0},
     {128, 128, 64},
     [](ArrayWorld& w) {
         w.fill_with([](int x, int y, int z) {
             if (y < 10 + ((x / 5) ^ (z / 3)) % 7)
                 return Material::kSand;
             return noise(4, x, y, z, 900) == Material::kRock ? Material::kRock
                    : y < 97                                  ? Material::kWater
                    : y < 99 && x < 40                        ? Material::kIce
                                                              : Material::kAir;
         });
     }},
    {"solid throughout",
     {0, 0, 0},
     {64, 256, 128},
     [](ArrayWorld& w) { w.fill_with([](int, int, int) { return Material::kRock; }); }},
    {"a shell around air, cut across boxes",
     {-100, -300, -5},
     {30, 10, 70},
     [](ArrayWorld& w) {
         w.fill({-100, -300, -5}, {30, 10, 70}, Material::kWall);
         w.fill({-98, -298, -3}, {28, 8, 68}, Material::kAir);
         w.fill({-40, -200, 10}, {-39, -100, 60}, Material::kRoof);
     }},
    {"far from the origin",
     {461'980, 480, -101'050},
     {462'090, 560, -100'950},
     [](ArrayWorld& w) {
         w.fill_with([](int x, int y, int z) {
             return y < 500 + static_cast<int>(
                                  core::hash64(static_cast<std::uint64_t>(x / 3) * 1000 +
                                               static_cast<std::uint64_t>(-z / 3)) &
                                  7)
                        ? Material::kGround
                        : noise(5, x, y, z, 500);
         });
     }},
    {"one voxel",
     {-1, -1, -1},
     {0, 0, 0},
     [](ArrayWorld& w) { w.set(-1, -1, -1, Material::kRoof); }},
};

using Random = std::mt19937_64;
double real(Random& r, double low, double high) {
    return low + core::unit_from(r()) * (high - low);
}
int whole(Random& r, int low, int high) {
    return low + static_cast<int>(r() % static_cast<std::uint64_t>(high - low));
}

core::Vec3 in_bounds(Random& r, const voxel::VoxelBounds& b, double around) {
    return {real(r, b.min[0] - around, b.max[0] + around),
            real(r, b.min[1] - around, b.max[1] + around),
            real(r, b.min[2] - around, b.max[2] + around)};
}
core::Vec3 grid_point(Random& r, const voxel::VoxelBounds& b, int around) {
    return {static_cast<double>(whole(r, b.min[0] - around, b.max[0] + around + 1)),
            static_cast<double>(whole(r, b.min[1] - around, b.max[1] + around + 1)),
            static_cast<double>(whole(r, b.min[2] - around, b.max[2] + around + 1))};
}
double component(Random& r) {
    return real(r, -1, 1);
}

struct RayCase {
    const char* name;
    int count;
    core::Ray (*make)(Random&, const voxel::VoxelBounds&);
};

const RayCase kRays[] = {
    {"anywhere, any way", 1000,
     [](Random& r, const voxel::VoxelBounds& b) {
         return core::Ray{in_bounds(r, b, 40), {component(r), component(r), component(r)}};
     }},
    {"from outside towards a point inside", 1000,
     [](Random& r, const voxel::VoxelBounds& b) {
         const core::Vec3 from = in_bounds(r, b, 400);
         const core::Vec3 to = in_bounds(r, b, 0);
         return core::Ray{from, core::normalized(to - from)};
     }},
    {"along an axis, with zeros of both signs", 600,
     [](Random& r, const voxel::VoxelBounds& b) {
         const double zero = r() % 2 == 0 ? 0.0 : -0.0;
         const double sign = r() % 2 == 0 ? 1 : -1;
         const core::Vec3 d[] = {{sign, zero, 0.0}, {zero, sign, -0.0}, {-0.0, zero, sign}};
         const core::Vec3 origin = r() % 2 == 0 ? in_bounds(r, b, 5) : grid_point(r, b, 3);
         return core::Ray{origin, d[r() % 3]};
     }},
    {"in a plane of the grid", 600,
     [](Random& r, const voxel::VoxelBounds& b) {
         core::Vec3 d{component(r), component(r), component(r)};
         core::Vec3 o = r() % 2 == 0 ? in_bounds(r, b, 5) : grid_point(r, b, 3);
         const auto axis = r() % 3;
         (axis == 0 ? d.x : axis == 1 ? d.y : d.z) = r() % 2 == 0 ? 0.0 : -0.0;
         return core::Ray{o, d};
     }},
    {"through edges and corners: whole coordinates, diagonals", 1000,
     [](Random& r, const voxel::VoxelBounds& b) {
         const auto part = [&] { return static_cast<double>(whole(r, -1, 2)); };
         core::Vec3 d{part(), part(), part()};
         if (d.x == 0 && d.y == 0 && d.z == 0)
             d.y = -1;
         return core::Ray{grid_point(r, b, 20), d};
     }},
    {"halves and thirds: many ties", 600,
     [](Random& r, const voxel::VoxelBounds& b) {
         const double slopes[] = {0.5, -0.5, 1, -1, 2, -2, 0.25, 1.0 / 3, -1.0 / 3, 3};
         const auto part = [&] { return slopes[r() % std::size(slopes)]; };
         return core::Ray{
             grid_point(r, b, 10) + core::Vec3{0.5, 0.5, 0.5} * (r() % 2 == 0 ? 1.0 : 0.0),
             {part(), part(), part()}};
     }},
    {"on a face, inwards and outwards", 600,
     [](Random& r, const voxel::VoxelBounds& b) {
         core::Vec3 o = in_bounds(r, b, 0);
         const auto axis = r() % 3;
         (axis == 0   ? o.x
          : axis == 1 ? o.y
                      : o.z) = std::floor(axis == 0   ? o.x
                                          : axis == 1 ? o.y
                                                      : o.z);
         return core::Ray{o, {component(r), component(r), component(r)}};
     }},
    {"on the outer faces of the world", 300,
     [](Random& r, const voxel::VoxelBounds& b) {
         core::Vec3 o = in_bounds(r, b, 1);
         const std::size_t axis = r() % 3;
         (axis == 0 ? o.x : axis == 1 ? o.y : o.z) = r() % 2 == 0 ? b.min[axis] : b.max[axis];
         return core::Ray{o, {component(r), component(r), component(r)}};
     }},
    {"almost along an axis", 300,
     [](Random& r, const voxel::VoxelBounds& b) {
         const double tiny[] = {1e-3, 1e-7, 1e-12, 1e-17, 1e-200, -1e-3, -1e-9, -1e-14};
         const auto part = [&] { return tiny[r() % std::size(tiny)]; };
         core::Vec3 d{part(), part(), part()};
         const auto axis = r() % 3;
         (axis == 0 ? d.x : axis == 1 ? d.y : d.z) = r() % 2 == 0 ? 1 : -1;
         return core::Ray{in_bounds(r, b, 3), d};
     }},
    {"not of unit length", 300,
     [](Random& r, const voxel::VoxelBounds& b) {
         const double scale[] = {1e-6, 1e-3, 0.125, 3, 1e4, 1e8};
         return core::Ray{
             in_bounds(r, b, 20),
             core::Vec3{component(r), component(r), component(r)} * scale[r() % std::size(scale)]};
     }},
    {"from far away", 12,
     [](Random& r, const voxel::VoxelBounds& b) {
         const core::Vec3 to = in_bounds(r, b, 0);
         const core::Vec3 away = core::normalized({component(r), component(r), component(r)});
         return core::Ray{to - away * real(r, 1e5, 1e6), away};
     }},
};

}  // namespace

TEST_CASE("the walker finds the voxel, face and time that single steps find",
          "[raytracer][walker]") {
    for (const WorldCase& w : kWorlds) {
        ArrayWorld world(w.min, w.max);
        w.fill(world);
        Pair pair(world);
        for (const RayCase& kind : kRays) {
            INFO(w.name << ": " << kind.name);
            Random random(core::hash64(static_cast<std::uint64_t>(&w - kWorlds),
                                       static_cast<std::uint64_t>(&kind - kRays)));
            for (int i = 0; i < kind.count; ++i) {
                const core::Ray ray = kind.make(random, world.level_bounds());
                pair.check(ray,
                           i % 8 == 7   ? walk::StopAt::find_end(voxel::Material::kWater)
                           : i % 4 == 3 ? walk::StopAt::kNotWater
                                        : walk::StopAt::kSolid,
                           i % 5 == 4 ? real(random, 0, 200) : core::kFar);
            }
            CHECK(pair.differences() == 0);
        }
    }
}

TEST_CASE("the walker agrees with single steps from faces of voxels it has hit",
          "[raytracer][walker]") {
    for (const WorldCase& w : kWorlds) {
        DYNAMIC_SECTION(w.name) {
            ArrayWorld world(w.min, w.max);
            w.fill(world);
            Pair pair(world);
            Random random(99);
            int started = 0;
            for (int i = 0; i < 3000; ++i) {
                const core::Ray first{
                    in_bounds(random, world.level_bounds(), 60),
                    core::normalized({component(random), component(random), component(random)})};
                const auto hit = pair.hit(first);
                if (!hit || hit->face == core::Face::kNone)
                    continue;
                ++started;
                // As shadow, mirror and water rays do: the point on the face as rounding left it,
                // snapped or not.
                core::Vec3 at = first.origin + first.direction * hit->t;
                const int axis = core::to_axis(hit->face);
                if (i % 2 == 0)
                    (axis == 0   ? at.x
                     : axis == 1 ? at.y
                                 : at.z) =
                        hit->voxel[axis] + (core::to_sign(hit->face) > 0 ? 1 : 0);
                core::VoxelCoord outside = hit->voxel;
                (axis == 0   ? outside.x
                 : axis == 1 ? outside.y
                             : outside.z) += core::to_sign(hit->face);
                const core::Vec3 n = core::to_normal(hit->face);
                core::Vec3 d =
                    core::normalized({component(random), component(random), component(random)});
                if (core::dot(d, n) < 0)
                    d = -d;
                pair.check_from({at, d}, outside,
                                i % 3 == 0 ? walk::StopAt::kNotWater : walk::StopAt::kSolid,
                                i % 5 == 0 ? 30.0 : core::kFar);
                pair.check_from({at, -d}, hit->voxel, walk::StopAt::kNotWater);
                if (voxel::see_through(hit->attr.material))
                    pair.check_from({at, -d}, hit->voxel,
                                    walk::StopAt::find_end(hit->attr.material));
            }
            if (w.max[0] - w.min[0] > 1)
                CHECK(started > 40);
            CHECK(pair.differences() == 0);
        }
    }
}

TEST_CASE("a ray along a face that starts on it stays in its voxels", "[raytracer][walker]") {
    // The sun in the north or south, or a wall seen edge on: a component is exactly zero and the
    // origin lies on a plane of that axis.
    struct Case {
        const char* name;
        core::Vec3 origin;
        core::Vec3 direction;
        core::VoxelCoord start;
        core::VoxelCoord hit;
    };
    const auto c = GENERATE(values<Case>({
        {"west neighbour, north", {10, 5.5, 10.5}, {0, 0, -1}, {9, 5, 10}, {9, 5, 2}},
        {"west neighbour, -0", {10, 5.5, 10.5}, {-0.0, 0, -1}, {9, 5, 10}, {9, 5, 2}},
        {"east neighbour, north", {10, 5.5, 10.5}, {0, 0, -1}, {10, 5, 10}, {10, 5, 2}},
        {"north neighbour, east", {10.5, 5.5, 10}, {1, 0, 0}, {10, 5, 9}, {30, 5, 9}},
        {"north neighbour, east and up", {10.5, 5.5, 10}, {1, 0.125, 0}, {10, 5, 9}, {30, 7, 9}},
        {"below, east", {10.5, 5, 10.5}, {1, 0, 0}, {10, 4, 10}, {30, 4, 10}},
        {"above, east", {10.5, 5, 10.5}, {1, 0, 0}, {10, 5, 10}, {30, 5, 10}},
    }));
    DYNAMIC_SECTION(c.name) {
        ArrayWorld world({0, 0, 0}, {40, 40, 40});
        world.fill({30, 0, 0}, {40, 40, 40}, Material::kWall);
        world.fill({0, 0, 0}, {30, 40, 3}, Material::kWall);
        Pair pair(world);
        pair.check_from({c.origin, c.direction}, c.start);
        const auto hit = pair.walker().first_hit_from({c.origin, c.direction}, c.start);
        REQUIRE(hit);
        CHECK(hit->voxel == c.hit);
    }
}

TEST_CASE("a box that could not be loaded stops rays and is marked", "[raytracer][walker]") {
    ArrayWorld world({-64, 0, -64}, {128, 256, 64});
    world.fill_with([](int x, int y, int z) { return noise(7, x, y, z, 3'000); });
    world.make_hole({0, 0, 0, 0});
    Pair pair(world);
    Random random(3);
    for (int i = 0; i < 2000; ++i)
        pair.check({in_bounds(random, world.level_bounds(), 30),
                    core::normalized({component(random), component(random), component(random)})},
                   i % 2 == 0 ? walk::StopAt::kSolid : walk::StopAt::kNotWater);
    CHECK(pair.differences() == 0);
    CHECK(pair.holes() > 200);
    CHECK(pair.hits() > pair.holes());
}

TEST_CASE("rays end at t_max, closed", "[raytracer][walker]") {
    ArrayWorld world({0, 0, 0}, {20, 20, 20});
    world.set(10, 5, 5, Material::kRoof);
    Pair pair(world);
    const core::Ray ray{{2, 5.5, 5.5}, {2, 0, 0}};
    CHECK(pair.walker().first_hit(ray, walk::StopAt::kSolid, 4.0));
    CHECK(pair.walker().first_hit(ray, walk::StopAt::kSolid, 4.0)->t == 4.0);
    CHECK_FALSE(pair.walker().first_hit(ray, walk::StopAt::kSolid, std::nextafter(4.0, 0)));
    CHECK_FALSE(pair.walker().first_hit(ray, walk::StopAt::kSolid, 0));
    CHECK(pair.walker().first_hit({{10.5, 5.5, 5.5}, {1, 0, 0}}, walk::StopAt::kSolid, 0));
}

TEST_CASE("a swimmer sees through water and stops at what is not", "[raytracer][walker]") {
    ArrayWorld world({0, 0, 0}, {8, 100, 8});
    world.fill({0, 20, 0}, {8, 60, 8}, Material::kWater);
    world.fill({0, 0, 0}, {8, 20, 8}, Material::kSand);
    Pair pair(world);
    const core::Ray down{{4.5, 90, 4.5}, {0, -1, 0}};
    CHECK(pair.hit(down)->voxel == core::VoxelCoord{4, 59, 4});
    CHECK(pair.hit(down, walk::StopAt::kNotWater)->voxel == core::VoxelCoord{4, 19, 4});
    CHECK(pair.hit(down, walk::StopAt::kNotWater)->face == core::Face::kTop);
    CHECK(pair.hit({{4.5, 30, 4.5}, {0, 1, 0}}, walk::StopAt::kNotWater) == std::nullopt);
}

TEST_CASE("an empty world has nothing to hit", "[raytracer][walker]") {
    ArrayWorld world({0, 0, 0}, {4, 4, 4});
    blocks::BlockManager blocks(world, kPlenty);
    walk::BlockReader reader(blocks);
    struct Case {
        const char* name;
        voxel::VoxelBounds bounds;
    };
    const auto c = GENERATE(values<Case>({{"nothing", {}},
                                          {"no width", {{0, 0, 0}, {0, 4, 4}}},
                                          {"no height", {{0, 4, 0}, {4, 4, 4}}},
                                          {"inside out", {{4, 4, 4}, {0, 0, 0}}}}));
    DYNAMIC_SECTION(c.name) {
        const walk::LevelCut cut(c.bounds, 0);
        walk::Walker walker(reader, cut);
        for (const core::Vec3 d : {core::Vec3{1, 0, 0}, {-1, 0, 0}, {0, -1, 0}, {0.3, 0.2, -0.9}})
            CHECK_FALSE(walker.first_hit({{2, 2, 2}, d}));
        CHECK(world.requests() == 0);
    }
}
