#include "tests/bench/entries/neutral_tracer.hpp"

#include <algorithm>

#include "raytracer/trace/shadow_groups.hpp"
#include "raytracer/walk/surroundings.hpp"

namespace terravox::bench {
namespace {

std::size_t pixel(int x, int y) noexcept {
    return static_cast<std::size_t>(y * NeutralScene::kWidthPx + x);
}

constexpr std::size_t kBoxMemory_bytes = std::size_t{1} << 30;

}  // namespace

NeutralTracer::NeutralTracer(NeutralWorld& world, int threads)
    : m_cut(world.info().bounds, 0), m_blocks(world, kBoxMemory_bytes) {
    const voxel::BoxRange range = voxel::boxes_over(world.info().bounds, 0);
    for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
        for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz)
            (void)m_blocks.get({0, bx, 0, bz});
    for (int i = 0; i < threads; ++i)
        m_workers.push_back(std::make_unique<Worker>(m_blocks, m_cut));
}

void NeutralTracer::begin(const NeutralView& view) {
    m_camera = view.camera();
    m_seen.assign(pixel(0, NeutralScene::kHeightPx), Seen{});
}

void NeutralTracer::trace_primary(int x0, int y0, int thread) {
    Worker& worker = *m_workers[static_cast<std::size_t>(thread)];
    worker.tile_blocks.clear();
    add_pixel_blocks({x0, y0, 1, kTracedTilePx, kTracedTilePx}, *m_camera, worker.beams,
                     worker.tile_blocks);
    for (const PixelBlock& block : worker.tile_blocks)
        trace_block(x0 + block.column, y0 + block.row, block, worker);
}

void NeutralTracer::trace_single(int x, int y, RayState& ray, Worker& worker) {
    Hit hit;
    if (worker.walk.first_hit(ray, StopAt::kSolid, kFar, hit) == WalkEnd::kHit)
        m_seen[pixel(x, y)] = {hit.t, hit.voxel, hit.face, true, false};
}

// As TileJob traces its blocks.
void NeutralTracer::trace_block(int x0, int y0, const PixelBlock& block, Worker& worker) {
    if (block.start.kind == BeamStart::Kind::kMiss)
        return;
    RayPacket packet;
    PacketWalk::Ends ends;
    std::uint32_t placed = 0;
    Hit hits[RayPacket::kLanes];
    const auto x_of = [&](int lane) { return x0 + lane % kPixelBlockSide; };
    const auto y_of = [&](int lane) { return y0 + lane / kPixelBlockSide; };
    if (worker.packets && block.start.kind == BeamStart::Kind::kPlane) {
        PrimaryLanes lanes = primary_lanes(*m_camera, block.start, m_cut);
        for (int i = 0; i < RayPacket::kLanes; ++i)
            lanes.px[i] = x_of(i) + 0.5, lanes.py[i] = y_of(i) + 0.5;
        placed = packet_steps()->primary(packet, lanes);
        ends = worker.packets->first_hits(packet, placed, hits);
    }
    for (int i = 0; i < RayPacket::kLanes; ++i) {
        if ((ends.hit >> i & 1) != 0) {
            m_seen[pixel(x_of(i), y_of(i))] = {hits[i].t, hits[i].voxel, hits[i].face, true, false};
        } else if ((ends.missed >> i & 1) == 0) {
            RayState ray(m_camera->ray(x_of(i) + 0.5, y_of(i) + 0.5));
            if ((placed >> i & 1) != 0)
                packet.update(i, ray);
            else if (!block.start.place(ray, m_cut))
                continue;
            trace_single(x_of(i), y_of(i), ray, worker);
        }
    }
}

void NeutralTracer::trace_shadow(int x0, int y0, int thread) {
    static_assert(kTracedTilePx * kTracedTilePx == ShadowGroups::kMost);
    Worker& worker = *m_workers[static_cast<std::size_t>(thread)];
    const Vec3 sun = neutral_sun();
    RayState states[ShadowGroups::kMost];
    WalkEnd ends[ShadowGroups::kMost];
    Seen* of[ShadowGroups::kMost];
    ShadowRay rays[ShadowGroups::kMost];
    std::size_t count = 0;
    const RayState towards_sun(Ray{{}, sun});
    for (int i = 0; i < kTracedTilePx * kTracedTilePx; ++i) {
        // Along a Z-order curve, as the rays of a wave are.
        const auto every_other = [](int bits) {
            return (bits & 1) | (bits >> 1 & 2) | (bits >> 2 & 4) | (bits >> 3 & 8);
        };
        const int x = x0 + every_other(i), y = y0 + every_other(i >> 1);
        Seen& seen = m_seen[pixel(x, y)];
        if (!seen.hit || seen.face == Face::kNone)
            continue;
        const Ray primary = m_camera->ray(x + 0.5, y + 0.5);
        const Vec3 from = primary.origin + primary.direction * seen.t;
        states[count] = towards_sun;
        for (int a = 0; a < 3; ++a)
            states[count].origin[a] = from[a];
        states[count].start_in(neighbour(seen.voxel, seen.face), 0);
        ends[count] = WalkEnd::kWaits;
        rays[count] = {from, &states[count], &ends[count]};
        of[count++] = &seen;
    }
    if (count == 0)
        return;
    ShadowGroups(worker.shafts, worker.packets ? &*worker.packets : nullptr, sun, 0)
        .trace({rays, count});
    for (std::size_t i = 0; i < count; ++i)
        of[i]->shadowed =
            (ends[i] == WalkEnd::kWaits ? worker.walk.any_hit(states[i], kFar, worker.occluder)
                                        : ends[i]) == WalkEnd::kHit;
}

std::size_t NeutralTracer::hits() const {
    return static_cast<std::size_t>(
        std::count_if(m_seen.begin(), m_seen.end(), [](const Seen& s) { return s.hit; }));
}

std::size_t NeutralTracer::shadowed() const {
    return static_cast<std::size_t>(
        std::count_if(m_seen.begin(), m_seen.end(), [](const Seen& s) { return s.shadowed; }));
}

}  // namespace terravox::bench
