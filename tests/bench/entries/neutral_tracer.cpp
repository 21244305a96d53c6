#include "tests/bench/entries/neutral_tracer.hpp"

#include <algorithm>

#include "raytracer/core/trace/fan_tracer.hpp"
#include "raytracer/core/walk/surroundings.hpp"

namespace terravox::bench {
namespace {

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
    m_seen.assign(NeutralScene::pixel_index(0, NeutralScene::kHeightPx), Seen{});
}

void NeutralTracer::trace_primary(int x0, int y0, int thread) {
    Worker& worker = *m_workers[static_cast<std::size_t>(thread)];
    worker.tile_blocks.clear();
    trace::add_pixel_blocks({x0, y0, 1, kTracedTilePx, kTracedTilePx}, *m_camera, worker.beams,
                            worker.tile_blocks);
    for (const trace::PixelBlock& block : worker.tile_blocks)
        trace_block(x0 + block.column, y0 + block.row, block, worker);
}

void NeutralTracer::trace_single(int x, int y, core::RayState& ray, Worker& worker) {
    walk::Hit hit;
    if (worker.walk.first_hit(ray, walk::StopAt::kSolid, core::kFar, hit) == walk::WalkEnd::kHit)
        m_seen[NeutralScene::pixel_index(x, y)] = {hit.t, hit.voxel, hit.face, true, false};
}

// As TileJob traces its blocks.
void NeutralTracer::trace_block(int x0, int y0, const trace::PixelBlock& block, Worker& worker) {
    if (block.start.kind == walk::BeamStart::Kind::kMiss)
        return;
    walk::RayPacket packet;
    walk::PacketWalk::Ends ends;
    std::uint32_t placed = 0;
    walk::Hit hits[walk::RayPacket::kLanes];
    const auto find_x = [&](int lane) { return x0 + lane % trace::kPixelBlockSide; };
    const auto find_y = [&](int lane) { return y0 + lane / trace::kPixelBlockSide; };
    if (worker.packets && block.start.kind == walk::BeamStart::Kind::kPlane) {
        walk::PrimaryLanes lanes = walk::primary_lanes(*m_camera, block.start, m_cut);
        for (int i = 0; i < walk::RayPacket::kLanes; ++i) {
            lanes.px[i] = find_x(i) + 0.5;
            lanes.py[i] = find_y(i) + 0.5;
        }
        placed = walk::packet_steps()->primary(packet, lanes);
        ends = worker.packets->first_hits(packet, placed, hits);
    }
    for (int i = 0; i < walk::RayPacket::kLanes; ++i) {
        if ((ends.hit >> i & 1) != 0) {
            m_seen[NeutralScene::pixel_index(find_x(i), find_y(i))] = {hits[i].t, hits[i].voxel,
                                                                       hits[i].face, true, false};
        } else if ((ends.missed >> i & 1) == 0) {
            core::RayState ray(m_camera->ray(find_x(i) + 0.5, find_y(i) + 0.5));
            if ((placed >> i & 1) != 0)
                packet.update(i, ray);
            else if (!block.start.place(ray, m_cut))
                continue;
            trace_single(find_x(i), find_y(i), ray, worker);
        }
    }
}

void NeutralTracer::trace_shadow(int x0, int y0, int thread) {
    static_assert(kTracedTilePx * kTracedTilePx == trace::ShadowGroups::kMax);
    Worker& worker = *m_workers[static_cast<std::size_t>(thread)];
    const core::Vec3 sun = neutral_sun();
    core::RayState states[trace::ShadowGroups::kMax];
    walk::WalkEnd ends[trace::ShadowGroups::kMax];
    Seen* of[trace::ShadowGroups::kMax];
    trace::ShadowRay rays[trace::ShadowGroups::kMax];
    std::size_t count = 0;
    const core::RayState towards_sun(core::Ray{{}, sun});
    for (int i = 0; i < kTracedTilePx * kTracedTilePx; ++i) {
        // Along a Z-order curve, as the rays of a wave are.
        const auto every_other = [](int bits) {
            return (bits & 1) | (bits >> 1 & 2) | (bits >> 2 & 4) | (bits >> 3 & 8);
        };
        const int x = x0 + every_other(i);
        const int y = y0 + every_other(i >> 1);
        Seen& seen = m_seen[NeutralScene::pixel_index(x, y)];
        if (!seen.hit || seen.face == core::Face::kNone)
            continue;
        const core::Ray primary = m_camera->ray(x + 0.5, y + 0.5);
        const core::Vec3 from = primary.origin + primary.direction * seen.t;
        states[count] = towards_sun;
        for (int a = 0; a < 3; ++a)
            states[count].origin[a] = from[a];
        states[count].start_in(walk::neighbour(seen.voxel, seen.face), 0);
        ends[count] = walk::WalkEnd::kWaits;
        rays[count] = {from, &states[count], &ends[count]};
        of[count++] = &seen;
    }
    if (count == 0)
        return;
    trace::ShadowGroups(worker.shafts, worker.packets ? &*worker.packets : nullptr, sun, 0)
        .trace({rays, count});
    for (std::size_t i = 0; i < count; ++i)
        of[i]->shadowed = (ends[i] == walk::WalkEnd::kWaits
                               ? worker.walk.any_hit(states[i], core::kFar, worker.occluder)
                               : ends[i]) == walk::WalkEnd::kHit;
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
