#include "voxelserver/http/box_replies.hpp"

#include <algorithm>
#include <cstdio>

#include "common/voxel/box_codec.hpp"
#include "common/voxel/morton.hpp"

namespace terravox::http {
namespace {

// Part of every entity tag: to be raised when the same box is to be sent as other bytes (another codec or setting of it).
constexpr int kCodecVersion = 1;

bool outside(const voxel::VoxelBounds& bounds, const voxel::BoxKey& key) noexcept {
    if (bounds.empty()) return true;
    const auto range = voxel::boxes_over(bounds, key.level);
    return key.bx < range.min.bx || key.bx >= range.max.bx || key.by < range.min.by || key.by >= range.max.by || key.bz < range.min.bz ||
           key.bz >= range.max.bz;
}

std::string etag_of(const voxel::Box& box) {
    char text[48];
    std::snprintf(text, sizeof text, "\"%016llx-%d\"", static_cast<unsigned long long>(box.checksum()), kCodecVersion);
    return text;
}

}  // namespace

void Gate::enter() {
    std::unique_lock lock(m_mutex);
    if (m_inside >= m_most_inside) {
        if (m_waiting >= m_most_waiting)
            throw Busy("make a box: " + std::to_string(m_inside) + " are being made and " + std::to_string(m_waiting) + " wait; ask again later");
        ++m_waiting;
        m_left.wait(lock, [&] { return m_inside < m_most_inside; });
        --m_waiting;
    }
    ++m_inside;
}

void Gate::leave() noexcept {
    {
        const std::lock_guard lock(m_mutex);
        --m_inside;
    }
    m_left.notify_one();
}

std::size_t BoxReplies::KeyHash::operator()(const voxel::BoxKey& key) const noexcept {
    return static_cast<std::size_t>(voxel::morton_encode(key.bx, key.by, key.bz) ^ (static_cast<std::uint64_t>(key.level) << 58));
}

BoxReplies::BoxReplies(voxel::World& world, util::StageTimes& times, const BoxRepliesOptions& options)
    : m_world(world),
      m_times(times),
      m_gate(std::max(options.makers, 1), std::max(options.queue, 0)),
      m_air(std::make_shared<const BoxReply>(BoxReply{"\"air-" + std::to_string(kCodecVersion) + "\"", nullptr})),
      m_cache(options.memory_bytes) {}

std::shared_ptr<const BoxReply> BoxReplies::get(const voxel::BoxKey& key) {
    // Nothing solid is out there. Answered without the cache, or whoever asks for all of space would empty it.
    if (outside(m_world.info().bounds, key)) return m_air;
    return m_cache.get(
        key, [&] { return make(key); },
        [](const std::shared_ptr<const BoxReply>& r) { return sizeof *r + r->etag.size() + (r->frame ? r->frame->capacity() : 0); });
}

std::shared_ptr<const BoxReply> BoxReplies::make(const voxel::BoxKey& key) {
    const Gate::Pass pass(m_gate);
    const auto box = m_world.box(key);
    if (!box) return m_air;
    const util::StageTimes::Scope timed(m_times, "compression");
    const auto frame = voxel::compress(*box);
    return std::make_shared<const BoxReply>(
        BoxReply{etag_of(*box), std::make_shared<const std::string>(reinterpret_cast<const char*>(frame.data()), frame.size())});
}

}  // namespace terravox::http
