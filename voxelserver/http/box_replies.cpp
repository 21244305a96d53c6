#include "voxelserver/http/box_replies.hpp"

#include <algorithm>
#include <cstdio>

#include "common/voxel/box_codec.hpp"

namespace terravox::http {
namespace {

// Part of every entity tag: to be raised when the same box is to be sent as other bytes (another codec or setting of it).
constexpr int kCodecVersion = 1;

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

BoxReplies::BoxReplies(voxel::World& world, util::StageTimes& times, const BoxRepliesOptions& options)
    : m_world(world),
      m_times(times),
      m_gate(std::max(options.makers, 1), std::max(options.queue, 0)),
      m_air(std::make_shared<const BoxReply>(BoxReply{"\"air-" + std::to_string(kCodecVersion) + "\"", nullptr})),
      m_cache(options.memory_bytes) {}

std::shared_ptr<const BoxReply> BoxReplies::get(const voxel::BoxKey& key) {
    // Nothing solid is out there. Answered without the cache, or whoever asks for all of space would empty it.
    const voxel::VoxelBounds& bounds = m_world.info().bounds;
    if (bounds.empty() || !voxel::boxes_over(bounds, key.level).contains(key)) return m_air;
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
