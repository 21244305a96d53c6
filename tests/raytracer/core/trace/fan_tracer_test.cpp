#include "raytracer/core/trace/fan_tracer.hpp"

#include <bit>
#include <cmath>
#include <random>

#include "tests/catch.hpp"
#include "tests/raytracer/landscape.hpp"

using namespace terravox;
using terravox::test::Job;
using terravox::test::landscape;
using terravox::test::small_scene;

namespace {

using Random = std::mt19937_64;

double real(Random& random, double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
}

core::Vec3 some_direction(Random& random) {
    // Along an axis and in a plane of two, too: packets take no such rays.
    static constexpr core::Vec3 kSpecial[] = {{0, 1, 0}, {1, 0, 0}, {0, 0.6, -0.8}, {0.8, 0.6, 0}};
    const auto which = random() % 16;
    if (which < std::size(kSpecial))
        return kSpecial[which];
    return core::normalized(
        {real(random, -1, 1), std::abs(real(random, -0.2, 1)) + 1e-3, real(random, -1, 1)});
}

/// Has directions by stream, and evaluates nothing.
class TableEvaluator final : public shade::RayEvaluator {
public:
    explicit TableEvaluator(std::vector<walk::FanDirections> table) : m_table(std::move(table)) {}
    walk::TracedRay primary(const core::Ray&, std::uint32_t) const noexcept override { return {}; }
    bool needs_surroundings(const walk::TracedRay&) const noexcept override { return false; }
    void shade(const walk::TracedRay&, shade::SampleSum&,
               std::vector<walk::TracedRay>&) const override {}
    walk::FanDirections directions(std::uint32_t stream) const override {
        return m_table.at(stream);
    }

private:
    std::vector<walk::FanDirections> m_table;
};

std::vector<walk::FanDirections> some_table(Random& random) {
    std::vector<walk::FanDirections> out(4);
    for (std::size_t i = 0; i < out.size(); ++i)
        for (const std::size_t count = i == 0 ? walk::kFanRays : 1 + random() % walk::kFanRays;
             out[i].count < count;)
            out[i].add(some_direction(random));
    return out;
}

walk::TracedRay some_fan(Random& random, const std::vector<walk::FanDirections>& table) {
    walk::TracedRay out;
    out.kind = walk::RayKind::kSky;
    out.stream = static_cast<std::uint32_t>(random() % table.size());
    out.fan_mask = walk::mask_of_first(table[out.stream].count);
    if (const auto some = static_cast<walk::FanMask>(out.fan_mask & random()); some != 0)
        out.fan_mask = some;
    const int level = static_cast<int>(random() % 2);
    const core::VoxelCoord voxel{static_cast<int>(random() % 160) - 75,
                                 static_cast<int>(random() % 45),
                                 static_cast<int>(random() % 140) - 65};
    const int edge = 1 << level;
    // Rays start on faces. Rounding may put them just outside of their voxel.
    const double off = random() % 3 == 0 ? -1e-12 : random() % 2 == 0 ? 0 : 0.25;
    out.ray.origin = {voxel.x + off, static_cast<double>(voxel.y / edge * edge), voxel.z + 0.75};
    out.state.start_in({voxel.x >= 0 ? voxel.x / edge : (voxel.x + 1) / edge - 1, voxel.y / edge,
                        voxel.z >= 0 ? voxel.z / edge : (voxel.z + 1) / edge - 1},
                       level);
    return out;
}

walk::WalkEnd walked(Job& job, trace::TracerTools& tools, core::RayState& state, double t_max) {
    walk::WalkEnd end = walk::WalkEnd::kWaits;
    while ((end = tools.walk.any_hit(state, t_max, tools.occluder)) == walk::WalkEnd::kWaits)
        (void)job.blocks.get(tools.walk.missing());
    return end;
}

/// What rays find that walk one by one from the start.
walk::FanEnds expected(Job& job, trace::TracerTools& tools, const walk::TracedRay& fan,
                       const walk::FanDirections& directions) {
    walk::FanEnds out;
    for (std::size_t d = 0; d < directions.count; ++d) {
        if (!walk::has(fan.fan_mask, d))
            continue;
        core::RayState state({fan.ray.origin, directions.to[d]});
        state.start_in({fan.state.voxel[0], fan.state.voxel[1], fan.state.voxel[2]},
                       fan.state.level);
        if (walked(job, tools, state, fan.t_max) != walk::WalkEnd::kHit)
            continue;
        out.blocked |= static_cast<walk::FanMask>(1U << d);
        if (tools.occluder.hole)
            out.holes |= static_cast<walk::FanMask>(1U << d);
    }
    return out;
}

}  // namespace

TEST_CASE("the rays of fans end as they do one by one", "[raytracer][trace][hole]") {
    const double reach = GENERATE(core::kFar, 12.5);
    const bool has_packets = GENERATE(true, false);
    Random random(41);
    auto world = landscape();
    world->make_hole({0, 0, 0, 1});
    Job job(small_scene(), std::size_t{256} << 20, std::move(world));
    trace::TracerTools tools(job.view, job.blocks, std::size_t{1} << 20);
    const auto table = some_table(random);
    tools.shading = std::make_unique<TableEvaluator>(table);
    if (!has_packets)
        tools.packets.reset();

    trace::FanTracer tracer;
    std::size_t blocked = 0;
    std::size_t holes = 0;
    std::size_t free = 0;
    // Some boxes are there in the second wave only.
    for (int wave = 0; wave < 3; ++wave) {
        std::vector<walk::TracedRay> rays(1 + random() % 1500);
        for (walk::TracedRay& ray : rays) {
            if (random() % 8 == 0)
                continue;  // no fan
            ray = some_fan(random, table);
            ray.t_max = reach;
        }
        const std::size_t count = rays.size();
        tiles::TraceCounts counts;
        tracer.trace(tools, rays, counts);
        CHECK((reach == core::kFar || rays.size() > count));
        for (std::size_t i = count; i < rays.size(); ++i) {
            REQUIRE(rays[i].only_blocked());
            rays[i].end = walked(job, tools, rays[i].state, rays[i].t_max);
            rays[i].hit.hole = rays[i].end == walk::WalkEnd::kHit && tools.occluder.hole;
        }
        tracer.take_singles(rays, counts);
        REQUIRE(rays.size() == count);
        std::size_t hole_rays = 0;
        for (std::size_t i = 0; i < count; ++i) {
            if (!rays[i].is_fan())
                continue;
            const walk::FanEnds truth = expected(job, tools, rays[i], table[rays[i].stream]);
            REQUIRE(tracer.ends(i).blocked == truth.blocked);
            REQUIRE(tracer.ends(i).holes == truth.holes);
            blocked += static_cast<std::size_t>(std::popcount(truth.blocked));
            hole_rays += static_cast<std::size_t>(std::popcount(truth.holes));
            free += static_cast<std::size_t>(std::popcount(rays[i].fan_mask)) -
                    static_cast<std::size_t>(std::popcount(truth.blocked));
        }
        CHECK(counts.hole_rays == hole_rays);
        holes += hole_rays;
    }
    CHECK(blocked > 500);
    CHECK(free > 500);
    CHECK(holes > 50);
}

TEST_CASE("a fan tracer that is cleared takes no rays of the next wave for its own",
          "[raytracer][trace]") {
    Job job(small_scene());
    trace::TracerTools tools(job.view, job.blocks, std::size_t{1} << 20);
    Random random(3);
    const auto table = some_table(random);
    tools.shading = std::make_unique<TableEvaluator>(table);
    trace::FanTracer tracer;
    tiles::TraceCounts counts;
    std::vector<walk::TracedRay> rays(5);
    for (walk::TracedRay& ray : rays)
        ray = some_fan(random, table);
    tracer.trace(tools, rays, counts);
    tracer.clear();
    std::vector<walk::TracedRay> others(50);
    tracer.take_singles(others, counts);
    CHECK(others.size() == 50);
}
