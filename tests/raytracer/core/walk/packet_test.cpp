// Packets must find what single rays find, to the last bit.
#include "raytracer/core/trace/fan_tracer.hpp"
#include "raytracer/core/walk/packet_walk.hpp"
#include "raytracer/core/walk/surroundings.hpp"
#include "tests/catch.hpp"
#include "tests/raytracer/core/walk/walk_fixture.hpp"

using namespace terravox;
using namespace terravox::test;

namespace {

/// How far the rays of a packet lie apart, voxels and share of the direction.
struct Spread {
    const char* name;
    double origin;
    double direction;
};

}  // namespace

TEST_CASE("packets find the voxel, face and time that single rays find", "[raytracer][packet]") {
    if (walk::packet_steps() == nullptr) {
        WARN("skipped: neither AVX2 nor AVX-512");
        return;
    }
    for (const double detail : {0.0, 1.0, 4.0}) {
        Fixture f(detail);
        for (const Spread& spread :
             {Spread{"neighbours", 0, 0.01}, Spread{"parallel", 3, 0},
              Spread{"all over the octant", 60, 0.9}, Spread{"whole coordinates", 8, 0.5}}) {
            INFO(spread.name << ", detail " << detail);
            walk::PacketWalk packets(f.reader, f.cut, *walk::packet_steps());
            Random random(17);
            int wrong = 0;
            int hits = 0;
            int in_packet = 0;
            int rays = 0;
            const bool whole = std::string(spread.name) == "whole coordinates";
            for (int round = 0; round < 250; ++round) {
                const core::Vec3 from{real(random, -120, 200), real(random, 30, 110),
                                      real(random, -130, 170)};
                const core::Vec3 towards{real(random, -1, 1), real(random, -1, 0.3),
                                         real(random, -1, 1)};
                walk::RayPacket packet;
                core::RayState states[walk::RayPacket::kLanes];
                std::optional<walk::Hit> wanted[walk::RayPacket::kLanes];
                for (int i = 0; i < 24 && packet.count < walk::RayPacket::kLanes; ++i) {
                    const auto off = [&](double by) {
                        return core::Vec3{real(random, -by, by), real(random, -by, by),
                                          real(random, -by, by)};
                    };
                    core::Ray ray{from + off(spread.origin), towards + off(spread.direction)};
                    if (whole)
                        ray = {{std::round(ray.origin.x), std::round(ray.origin.y),
                                std::round(ray.origin.z)},
                               {std::round(ray.direction.x * 3) / 3, -1,
                                std::round(ray.direction.z * 2)}};
                    core::RayState state(ray);
                    if (!state.enter(f.cut.entry_bounds()) || !walk::RayPacket::accepts(state) ||
                        !packet.fits(state))
                        continue;
                    states[packet.count] = state;
                    wanted[packet.count] = f.walker.first_hit(ray);
                    packet.add(state);
                }
                if (packet.count == 0)
                    continue;
                walk::RayPacket occlusion = packet;
                const std::uint32_t all = (1u << packet.count) - 1;
                walk::Hit found[walk::RayPacket::kLanes];
                const walk::PacketWalk::Ends ends = packets.first_hits(packet, all, found);
                const walk::PacketWalk::Ends stopped = packets.any_hits(occlusion, all);
                CHECK((ends.hit & ends.missed) == 0);
                for (int i = 0; i < packet.count; ++i) {
                    ++rays;
                    hits += wanted[i] ? 1 : 0;
                    const bool hit = (ends.hit >> i & 1) != 0;
                    const bool missed = (ends.missed >> i & 1) != 0;
                    in_packet += hit || missed ? 1 : 0;
                    std::optional<walk::Hit> end = hit ? std::optional(found[i]) : std::nullopt;
                    if (!hit && !missed) {
                        packet.update(i, states[i]);
                        end = f.finish(states[i]);
                    }
                    if (!same(end, wanted[i]))
                        ++wrong;
                    if ((stopped.hit >> i & 1) != 0 && !wanted[i])
                        ++wrong;
                    if ((stopped.missed >> i & 1) != 0 && wanted[i])
                        ++wrong;
                }
            }
            CHECK(wrong == 0);
            CHECK(hits > rays / 5);
            // Where levels change, rays go on alone.
            CHECK(in_packet > (detail < 4 ? rays / 3 : 0));
            CHECK((detail == 0 || in_packet < rays));
        }
    }
}

TEST_CASE("primary rays made in a packet are those of the camera", "[raytracer][packet]") {
    if (walk::packet_steps() == nullptr)
        return;
    Fixture f(1);
    Random random(4);
    int lanes_seen = 0;
    int wrong = 0;
    for (int round = 0; round < 600; ++round) {
        const core::Vec3 eye{real(random, -300, 300), real(random, 20, 300),
                             real(random, -300, 300)};
        const core::Vec3 to{real(random, -90, 170), real(random, -20, 80), real(random, -100, 140)};
        const scene::Camera camera(eye, to, real(random, 10, 110), 640, 360);
        const double x = real(random, 0, 636);
        const double y = real(random, 0, 356);
        const core::Vec3 corners[4] = {camera.ray(x, y).direction, camera.ray(x + 4, y).direction,
                                       camera.ray(x, y + 4).direction,
                                       camera.ray(x + 4, y + 4).direction};
        walk::Beam beam;
        if (!walk::Beam::make(eye, corners, beam))
            continue;
        walk::BeamMarch march(f.reader, f.cut);
        const walk::BeamStart start = march.march(beam, {});
        if (start.kind != walk::BeamStart::Kind::kPlane)
            continue;
        walk::PrimaryLanes lanes = walk::primary_lanes(camera, start, f.cut);
        for (int i = 0; i < walk::RayPacket::kLanes; ++i) {
            lanes.px[i] = x + i % 4 + real(random, 0, 1);
            lanes.py[i] = y + i / 4 + real(random, 0, 1);
        }
        walk::RayPacket packet;
        const std::uint32_t placed = walk::packet_steps()->primary(packet, lanes);
        for (int i = 0; i < walk::RayPacket::kLanes; ++i) {
            if ((placed >> i & 1) == 0)
                continue;
            ++lanes_seen;
            core::RayState wanted(camera.ray(lanes.px[i], lanes.py[i]));
            core::RayState found = wanted;
            if (!start.place(wanted, f.cut))
                ++wrong;
            packet.update(i, found);
            for (int a = 0; a < 3; ++a)
                if (found.voxel[a] != wanted.voxel[a] || packet.origin[a][i] != wanted.origin[a] ||
                    packet.direction[a][i] != wanted.direction[a] ||
                    packet.inverse[a][i] != wanted.inverse[a])
                    ++wrong;
            if (found.t != wanted.t || found.face != wanted.face)
                ++wrong;
        }
    }
    CHECK(wrong == 0);
    CHECK(lanes_seen > 1000);
}

TEST_CASE("groups of shadow rays answer what single rays answer", "[raytracer][packet]") {
    struct Case {
        const char* name;
        core::Vec3 sun;
        double radius_rad;
        double detail;
    };
    for (const Case& c : {Case{"high sun", {0.3, 0.9, 0.2}, 0, 0},
                          Case{"low sun in the west", {-0.8, 0.2, 0.3}, 0, 0},
                          Case{"low sun in the east, levels", {0.7, 0.15, -0.1}, 0.01, 1},
                          Case{"low sun in the south, levels", {0.1, 0.3, 0.9}, 0, 2},
                          Case{"high sun, levels", {-0.2, 0.8, -0.4}, 0, 2},
                          Case{"broad sun in the zenith", {0, 1, 0.01}, 0.05, 1}}) {
        DYNAMIC_SECTION(c.name) {
            Fixture f(c.detail);
            std::optional<walk::PacketWalk> packets = walk::packet_walk(f.reader, f.cut);
            walk::ShaftMarch shafts(f.reader, f.cut);
            const core::Vec3 sun = core::normalized(c.sun);
            trace::ShadowGroups groups(shafts, packets ? &*packets : nullptr, sun, c.radius_rad);
            Random random(23);
            std::size_t wrong = 0;
            std::size_t dark = 0;
            std::size_t free = 0;
            for (int group = 0; group < 120; ++group) {
                const core::Vec3 eye{-80, 60, -90};
                const core::Vec3 towards{real(random, -1, 1), real(random, -0.8, -0.1),
                                         real(random, -1, 1)};
                core::RayState states[trace::ShadowGroups::kMax], alone[trace::ShadowGroups::kMax];
                walk::WalkEnd ends[trace::ShadowGroups::kMax];
                trace::ShadowRay rays[trace::ShadowGroups::kMax];
                std::size_t count = 0;
                for (std::size_t i = 0; i < trace::ShadowGroups::kMax; ++i) {
                    const core::Ray ray{
                        eye, core::normalized(towards + core::Vec3{real(random, 0, 0.2),
                                                                   real(random, 0, 0.2),
                                                                   real(random, 0, 0.2)})};
                    const std::optional<walk::Hit> hit = f.walker.first_hit(ray);
                    if (!hit || hit->face == core::Face::kNone)
                        continue;
                    const core::Vec3 from = ray.origin + ray.direction * hit->t;
                    const double r = c.radius_rad / 2;
                    states[count] = core::RayState(core::Ray{
                        from,
                        core::normalized(sun + core::Vec3{real(random, -r, r), real(random, -r, r),
                                                          real(random, -r, r)})});
                    states[count].start_in(walk::neighbour(hit->voxel, hit->face), hit->level);
                    alone[count] = states[count];
                    ends[count] = walk::WalkEnd::kWaits;
                    rays[count] = {from, &states[count], &ends[count]};
                    ++count;
                }
                (void)groups.trace({rays, count});
                for (std::size_t i = 0; i < count; ++i) {
                    const auto finish = [&](core::RayState& ray) {
                        while (true) {
                            walk::Occluder none;
                            const walk::WalkEnd end = f.single.any_hit(ray, core::kFar, none);
                            if (end != walk::WalkEnd::kWaits)
                                return end;
                            (void)f.blocks.get(f.single.missing());
                        }
                    };
                    const walk::WalkEnd wanted = finish(alone[i]);
                    const walk::WalkEnd found =
                        ends[i] == walk::WalkEnd::kWaits ? finish(states[i]) : ends[i];
                    if (found != wanted)
                        ++wrong;
                    (wanted == walk::WalkEnd::kHit ? dark : free) += 1;
                }
            }
            CHECK(wrong == 0);
            CHECK(dark > 500);
            CHECK(free > 500);
        }
    }
}
