#include "raytracer/farm/coordinator/box_supplier.hpp"

#include <algorithm>

#include "common/thread/start_threads.hpp"
#include "common/voxel/box.hpp"
#include "raytracer/farm/wire/frames.hpp"

namespace terravox::farm {
namespace {

// Threads per requester: one that accepts nothing must not block them all.
constexpr int kMaxServing = 2;
constexpr std::uint64_t kMaxQueued_bytes = std::uint64_t{8}
                                           << 20;    // far below what makes a sender wait
constexpr std::chrono::milliseconds kLookAgain{50};  // interval between checks of slow links

/// Aborts the packing of a box that is a hole, so that the cache does not store it.
struct IsHole {};

}  // namespace

BoxSupplier::BoxSupplier(blocks::BlockManager& blocks, std::uint64_t world_id,
                         std::size_t memory_bytes, int threads)
    : m_blocks(blocks), m_world_id(world_id), m_packed(memory_bytes) {
    thread::start_threads(
        m_threads, static_cast<std::size_t>(threads), [this] { serve(); }, [this] { stop(); });
}

void BoxSupplier::stop() {
    {
        const std::lock_guard lock(m_mutex);
        m_stop = true;
    }
    m_work.notify_all();
}

BoxSupplier::~BoxSupplier() {
    stop();
    for (std::thread& t : m_threads)
        t.join();
}

bool BoxSupplier::request(std::uint64_t requester, const farm::BoxRequest& boxes,
                          const ReplyChannel& channel) {
    if (boxes.world_id() != m_world_id)
        return false;
    {
        const std::lock_guard lock(m_mutex);
        auto found = std::find_if(m_requesters.begin(), m_requesters.end(),
                                  [&](const auto& a) { return a->id == requester; });
        if (found == m_requesters.end()) {
            m_requesters.push_back(
                std::make_shared<Requester>(Requester{requester, channel, {}, 0}));
            found = m_requesters.end() - 1;
        }
        if ((*found)->keys.size() + static_cast<std::size_t>(boxes.keys_size()) > kMaxWaiting)
            return false;
        for (const farm::BoxKey& key : boxes.keys())
            (*found)->keys.push_back(from_frame(key));
    }
    m_work.notify_all();
    return true;
}

void BoxSupplier::forget(std::uint64_t requester) {
    std::unique_lock lock(m_mutex);
    const auto found = std::find_if(m_requesters.begin(), m_requesters.end(),
                                    [&](const auto& a) { return a->id == requester; });
    if (found == m_requesters.end())
        return;
    const auto gone = *found;
    m_requesters.erase(found);
    gone->keys.clear();
    m_idle.wait(lock, [&] { return gone->serving == 0; });
}

std::shared_ptr<const BoxSupplier::Packed> BoxSupplier::packed(const voxel::BoxKey& key) {
    const auto make = [&] {
        auto out = std::make_shared<Packed>();
        const blocks::BlockPin block = m_blocks.get(key);
        if (block->hole)
            throw IsHole();
        out->air = !block->box;
        if (block->box)
            out->frame = voxel::compress(*block->box);
        return std::shared_ptr<const Packed>(std::move(out));
    };
    try {
        return m_packed.get(key, make,
                            [](const std::shared_ptr<const Packed>& p) { return p->frame.size(); });
    } catch (const IsHole&) {
        return nullptr;  // for this picture: the block manager knows for how long
    }
}

// The next requester to be served, once there is one; none when it stops.
BoxSupplier::Requesters::iterator BoxSupplier::next(std::unique_lock<std::mutex>& lock) {
    while (!m_stop) {
        bool slow = false;
        for (auto at = m_requesters.begin(); at != m_requesters.end(); ++at) {
            if ((*at)->keys.empty() || (*at)->serving >= kMaxServing)
                continue;
            if ((*at)->channel.queued_bytes() < kMaxQueued_bytes)
                return at;
            slow = true;
        }
        if (slow)
            m_work.wait_for(lock, kLookAgain);
        else
            m_work.wait(lock);
    }
    return m_requesters.end();
}

void BoxSupplier::serve() {
    std::unique_lock lock(m_mutex);
    while (true) {
        const auto at = next(lock);
        if (m_stop)
            return;
        const auto requester = *at;
        std::rotate(at, at + 1, m_requesters.end());  // the others are served first next time
        const voxel::BoxKey key = requester->keys.front();
        requester->keys.pop_front();
        ++requester->serving;
        lock.unlock();
        farm::Frame frame;
        farm::BoxReply& reply = *frame.mutable_box();
        reply.set_world_id(m_world_id);
        to_frame(key, *reply.mutable_key());
        const voxel::WorldInfo& world = m_blocks.world_info();
        if (key.level < 0 || key.level >= world.levels ||
            !voxel::boxes_over(world.bounds, key.level).contains(key)) {
            reply.set_air(true);  // beyond the world
        } else {
            const auto box = packed(key);
            if (!box)
                reply.set_hole("the coordinator cannot load it");
            else if (box->air)
                reply.set_air(true);
            else
                reply.set_frame(box->frame.data(), box->frame.size());
        }
        (void)requester->channel.send(std::move(frame));
        lock.lock();
        if (--requester->serving == 0)
            m_idle.notify_all();
        m_work.notify_one();
    }
}

}  // namespace terravox::farm
