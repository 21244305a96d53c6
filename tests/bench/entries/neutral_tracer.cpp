#include "tests/bench/entries/neutral_tracer.hpp"

#include <algorithm>

#include "raytracer/walk/surroundings.hpp"

namespace terravox::bench {
namespace {

std::size_t pixel(int x, int y) noexcept { return static_cast<std::size_t>(y * NeutralScene::kWidthPx + x); }

constexpr std::size_t kBoxMemory_bytes = std::size_t{1} << 30;

}  // namespace

NeutralTracer::NeutralTracer(NeutralWorld& world, int threads) : m_cut(world.info().bounds, 0), m_blocks(world, kBoxMemory_bytes) {
    const voxel::BoxRange range = voxel::boxes_over(world.info().bounds, 0);
    for (std::int32_t bx = range.min.bx; bx < range.max.bx; ++bx)
        for (std::int32_t bz = range.min.bz; bz < range.max.bz; ++bz) (void)m_blocks.get({0, bx, 0, bz});
    for (int i = 0; i < threads; ++i) m_workers.push_back(std::make_unique<Worker>(m_blocks, m_cut));
}

void NeutralTracer::begin(const NeutralView& view) {
    m_camera = view.camera();
    m_seen.assign(pixel(0, NeutralScene::kHeightPx), Seen{});
}

void NeutralTracer::trace_primary(int x0, int y0, int thread) {
    Worker& worker = *m_workers[static_cast<std::size_t>(thread)];
    worker.tile_blocks.clear();
    add_pixel_blocks({x0, y0, 1, kTracedTilePx, kTracedTilePx}, *m_camera, worker.beams, worker.tile_blocks);
    Hit hit;
    for (const PixelBlock& block : worker.tile_blocks)
        for (int y = y0 + block.row; y < y0 + block.row + block.rows; ++y)
            for (int x = x0 + block.column; x < x0 + block.column + block.columns; ++x) {
                RayState ray(m_camera->ray(x + 0.5, y + 0.5));
                if (block.start.place(ray, m_cut) && worker.walk.first_hit(ray, StopAt::kSolid, kFar, hit) == WalkEnd::kHit)
                    m_seen[pixel(x, y)] = {hit.t, hit.voxel, hit.face, true, false};
            }
}

void NeutralTracer::trace_shadow(int x0, int y0, int thread) {
    Worker& worker = *m_workers[static_cast<std::size_t>(thread)];
    for (int y = y0; y < y0 + kTracedTilePx; y += kPixelBlockSide)
        for (int x = x0; x < x0 + kTracedTilePx; x += kPixelBlockSide) trace_shadow_block(x, y, worker);
}

void NeutralTracer::trace_shadow_block(int x0, int y0, Worker& worker) {
    constexpr int kMost = kPixelBlockSide * kPixelBlockSide;
    const Vec3 sun = neutral_sun();
    RayState rays[kMost];
    Seen* of[kMost];
    int count = 0;
    Shaft shaft(sun);
    for (int y = y0; y < y0 + kPixelBlockSide; ++y)
        for (int x = x0; x < x0 + kPixelBlockSide; ++x) {
            Seen& seen = m_seen[pixel(x, y)];
            if (!seen.hit || seen.face == Face::kNone) continue;
            const Ray primary = m_camera->ray(x + 0.5, y + 0.5);
            const Vec3 from = primary.origin + primary.direction * seen.t;
            rays[count] = RayState(Ray{from, sun});
            rays[count].start_in(neighbour(seen.voxel, seen.face), 0);
            shaft.add(from, rays[count]);
            of[count++] = &seen;
        }
    if (count == 0) return;
    const std::int32_t free_from = worker.shafts.free_from(shaft);
    for (int i = 0; i < count; ++i)
        of[i]->shadowed = !ShaftMarch::is_free(shaft, rays[i], free_from) && worker.walk.any_hit(rays[i], kFar, worker.occluder) == WalkEnd::kHit;
}

std::size_t NeutralTracer::hits() const {
    return static_cast<std::size_t>(std::count_if(m_seen.begin(), m_seen.end(), [](const Seen& s) { return s.hit; }));
}

std::size_t NeutralTracer::shadowed() const {
    return static_cast<std::size_t>(std::count_if(m_seen.begin(), m_seen.end(), [](const Seen& s) { return s.shadowed; }));
}

}  // namespace terravox::bench
