// Rays that pass thin things must end as in a world without them.
#include "raytracer/core/base/material_groups.hpp"
#include "raytracer/core/walk/lane_walk.hpp"
#include "raytracer/core/walk/packet_walk.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/core/walk/walk_fixture.hpp"

using namespace terravox;
using namespace terravox::test;
using voxel::Material;

namespace {

/// Grass, trunks, wires and crowns above a rough ground.
Material garden_at(int x, int y, int z) {
    if (y < (x * x + z * z) / 600)
        return Material::kGround;
    const std::uint64_t h = core::hash64(static_cast<std::uint64_t>(x + 1000) << 32 |
                                         static_cast<std::uint32_t>(z + 1000));
    if (y <= (x * x + z * z) / 600 + 1 && h % 3 != 0)
        return Material::kLowVegetation;
    if (h % 17 == 1 && y < 14)
        return Material::kTrunk;
    if (y == 20 && x % 5 == 0)
        return Material::kWire;
    return y >= 14 && y < 17 && h % 4 == 0 ? Material::kHighVegetation : Material::kAir;
}

struct Garden {
    explicit Garden(bool has_thin, walk::ThinThings thin = walk::ThinThings::kBlock)
        : world(made(has_thin)),
          cut(world->info().bounds, {0, 60, 0}, 0.03, 0, 0, 0),
          blocks(*world, std::size_t{1} << 30),
          reader(blocks, std::size_t{64} << 20),
          single(reader, cut, thin) {}

    static std::unique_ptr<PyramidWorld> made(bool has_thin) {
        auto finest = std::make_unique<ArrayWorld>(ArrayWorld::Coord{-70, -4, -70},
                                                   ArrayWorld::Coord{70, 30, 70});
        finest->fill_with([&](int x, int y, int z) {
            const Material material = garden_at(x, y, z);
            return !has_thin && core::is_thin(material) ? Material::kAir : material;
        });
        return std::make_unique<PyramidWorld>(std::move(finest), 1);
    }
    walk::WalkEnd finish(core::RayState& ray) {
        while (true) {
            const walk::WalkEnd end = single.any_hit(ray, core::kFar, occluder);
            if (end != walk::WalkEnd::kWaits)
                return end;
            (void)blocks.get(single.missing());
        }
    }
    std::unique_ptr<PyramidWorld> world;
    walk::LevelCut cut;
    blocks::BlockManager blocks;
    walk::BlockReader reader;
    walk::RayWalk single;
    walk::Occluder occluder;
};

core::RayState random_ray(Random& random) {
    const double x = std::floor(real(random, -60, 60));
    const double z = std::floor(real(random, -60, 60));
    const double y = std::floor((x * x + z * z) / 600) + 1;
    core::RayState out(
        {{x + 0.5, y + 0.25, z + 0.5},
         core::normalized({real(random, 0.1, 1), real(random, 0.02, 1), real(random, 0.1, 1)})});
    out.start_in({static_cast<int>(x), static_cast<int>(y), static_cast<int>(z)}, 0);
    return out;
}

}  // namespace

TEST_CASE("rays that pass thin things end as where there are none", "[raytracer][walker]") {
    Garden bare(false);
    Garden full(true);
    Garden passed(true, walk::ThinThings::kPass);
    Random random(11);
    constexpr int kGroups = 400;
    int wrong = 0;
    int free = 0;
    int freed = 0;
    for (int group = 0; group < kGroups; ++group) {
        core::RayState rays[walk::RayPacket::kLanes];
        walk::WalkEnd wanted[walk::RayPacket::kLanes];
        walk::RayPacket packet;
        for (core::RayState& ray : rays) {
            ray = random_ray(random);
            core::RayState copies[] = {ray, ray, ray};
            const auto i = static_cast<std::size_t>(&ray - rays);
            wanted[i] = bare.finish(copies[0]);
            wrong += passed.finish(copies[1]) != wanted[i] ? 1 : 0;
            free += wanted[i] == walk::WalkEnd::kMiss ? 1 : 0;
            freed += full.finish(copies[2]) != wanted[i] ? 1 : 0;
            packet.add(ray);
        }
        if (walk::packet_steps() == nullptr)
            continue;
        walk::PacketWalk packets(passed.reader, passed.cut, *walk::packet_steps(),
                                 walk::ThinThings::kPass);
        const walk::PacketWalk::Ends ends = packets.any_hits(packet, 0xffff);
        walk::LaneWalk lanes(passed.reader, passed.cut, *walk::packet_steps(),
                             walk::ThinThings::kPass);
        std::vector<walk::LaneRay> sent;
        core::RayState alongside[walk::RayPacket::kLanes];
        walk::WalkEnd side_ends[walk::RayPacket::kLanes];
        for (int i = 0; i < walk::RayPacket::kLanes; ++i) {
            alongside[i] = rays[i];
            side_ends[i] = walk::WalkEnd::kWaits;
            sent.push_back({&alongside[i], &side_ends[i]});
        }
        lanes.trace(sent);
        for (int i = 0; i < walk::RayPacket::kLanes; ++i) {
            walk::WalkEnd end = walk::WalkEnd::kWaits;
            if ((ends.hit >> i & 1) != 0)
                end = walk::WalkEnd::kHit;
            if ((ends.missed >> i & 1) != 0)
                end = walk::WalkEnd::kMiss;
            if (end == walk::WalkEnd::kWaits) {
                packet.update(i, rays[i]);
                end = passed.finish(rays[i]);
            }
            if (side_ends[i] == walk::WalkEnd::kWaits)
                side_ends[i] = passed.finish(alongside[i]);
            wrong += end != wanted[i] ? 1 : 0;
            wrong += side_ends[i] != wanted[i] ? 1 : 0;
        }
    }
    CHECK(wrong == 0);
    CHECK(free > kGroups);
    CHECK(freed > kGroups);
}
