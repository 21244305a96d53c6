#include "raytracer/farm/worker/coordinator_world.hpp"

#include <algorithm>

#include "common/thread/stop.hpp"
#include "common/util/error.hpp"
#include "common/voxel/box.hpp"
#include "raytracer/farm/wire/frames.hpp"

namespace terravox::farm {

void BoxShelf::open(std::uint64_t world_id) {
    const std::lock_guard lock(m_mutex);
    std::erase(m_worlds, world_id);
    m_worlds.push_front(world_id);
    for (; m_worlds.size() > m_max_worlds; m_worlds.pop_back())
        m_frames.erase_if(
            [gone = m_worlds.back()](const Key& key) { return key.world_id == gone; });
}

CoordinatorWorld::CoordinatorWorld(voxel::WorldInfo info, std::uint64_t world_id,
                                   std::function<bool(farm::Frame)> send, BoxShelf& shelf)
    : m_info(std::move(info)), m_world_id(world_id), m_send(std::move(send)), m_shelf(shelf) {
    m_shelf.open(m_world_id);
}

std::shared_ptr<const voxel::Box> CoordinatorWorld::unpacked(const voxel::BoxKey& key,
                                                             const BoxShelf::Frame& frame) const {
    if (frame.empty())
        return nullptr;
    auto box = voxel::decompress_box(frame, "box " + voxel::to_string(key) + " of the coordinator");
    if (box->key() != key)
        throw util::Error("fetch box " + voxel::to_string(key) + ": the coordinator sent box " +
                          voxel::to_string(box->key()));
    return box;
}

std::shared_ptr<const voxel::Box> CoordinatorWorld::box(const voxel::BoxKey& key) {
    voxel::BoxOutcome out;
    boxes({&key, 1},
          [&](const voxel::BoxKey&, voxel::BoxOutcome outcome) { out = std::move(outcome); });
    if (out.failure)
        std::rethrow_exception(out.failure);
    return out.box;
}

void CoordinatorWorld::boxes(std::span<const voxel::BoxKey> keys, const voxel::TakeBox& take) {
    const auto hand_over = [&](const voxel::BoxKey& key, const BoxShelf::Frame* frame,
                               const std::string& hole) {
        voxel::BoxOutcome outcome;
        try {
            if (frame == nullptr && hole.empty())
                throw thread::StoppedError("fetch box " + voxel::to_string(key) +
                                           ": the link to the coordinator has ended");
            if (frame == nullptr)
                throw util::Error("fetch box " + voxel::to_string(key) + ": " + hole);
            outcome.box = unpacked(key, *frame);
        } catch (...) {
            outcome.failure = std::current_exception();
        }
        take(key, std::move(outcome));
    };
    std::vector<std::pair<voxel::BoxKey, std::shared_ptr<PendingBox>>> open;
    farm::Frame request;
    request.mutable_need_box()->set_world_id(m_world_id);
    for (const voxel::BoxKey& key : keys) {
        if (const auto kept = m_shelf.find({m_world_id, key})) {
            hand_over(key, kept.get(), {});
            continue;
        }
        const std::lock_guard lock(m_mutex);
        auto& pending = m_pending[key];
        if (!pending) {
            pending = std::make_shared<PendingBox>();
            to_frame(key, *request.mutable_need_box()->add_keys());
        }
        ++pending->waiting;
        open.emplace_back(key, pending);
    }
    if (request.need_box().keys_size() > 0 && !m_send(std::move(request)))
        stop();
    while (!open.empty()) {
        std::vector<std::pair<voxel::BoxKey, std::shared_ptr<PendingBox>>> here;
        bool stopped = false;
        {
            std::unique_lock lock(m_mutex);
            const auto is_here = [&](const auto& o) { return o.second->here; };
            m_replied.wait(
                lock, [&] { return m_stop || std::any_of(open.begin(), open.end(), is_here); });
            stopped = m_stop;
            for (auto it = open.begin(); it != open.end();)
                if (stopped || is_here(*it)) {
                    here.push_back(std::move(*it));
                    it = open.erase(it);
                } else
                    ++it;
            for (const auto& [key, pending] : here)
                if (--pending->waiting == 0)
                    m_pending.erase(key);
        }
        for (const auto& [key, pending] : here)
            hand_over(key, pending->here ? pending->frame.get() : nullptr,
                      pending->here ? pending->hole : std::string());
    }
}

bool CoordinatorWorld::on_reply(const farm::BoxReply& reply) {
    if (reply.world_id() != m_world_id)
        return true;  // of a picture that has ended
    const voxel::BoxKey key = from_frame(reply.key());
    std::shared_ptr<const BoxShelf::Frame> frame;
    if (reply.outcome_case() == farm::BoxReply::kFrame) {
        const auto bytes = std::as_bytes(std::span(reply.frame()));
        frame = std::make_shared<const BoxShelf::Frame>(bytes.begin(), bytes.end());
    } else if (reply.outcome_case() == farm::BoxReply::kAir) {
        frame = std::make_shared<const BoxShelf::Frame>();
    }
    {
        const std::lock_guard lock(m_mutex);
        const auto pending = m_pending.find(key);
        if (pending == m_pending.end())
            return m_stop;
        pending->second->here = true;
        pending->second->frame = frame;
        pending->second->hole =
            reply.outcome_case() == farm::BoxReply::kHole && !reply.hole().empty()
                ? reply.hole()
                : "the coordinator gave no answer";
    }
    m_replied.notify_all();
    if (frame)
        m_shelf.put({m_world_id, key}, frame);
    return true;
}

voxel::ColumnExtent CoordinatorWorld::column(int level, std::int32_t bx, std::int32_t bz) {
    const voxel::BoxRange range = voxel::boxes_over(m_info.bounds, level);
    if (bx < range.min.bx || bx >= range.max.bx || bz < range.min.bz || bz >= range.max.bz)
        return {};
    return {range.min.by, range.max.by};
}

void CoordinatorWorld::stop() noexcept {
    {
        const std::lock_guard lock(m_mutex);
        m_stop = true;
    }
    m_replied.notify_all();
}

std::shared_ptr<const voxel::Box> FallbackWorld::box(const voxel::BoxKey& key) {
    try {
        return m_own->box(key);
    } catch (const util::Error&) {
        return m_helper.box(key);
    }
}

void FallbackWorld::boxes(std::span<const voxel::BoxKey> keys, const voxel::TakeBox& take) {
    std::vector<voxel::BoxKey> missing;
    m_own->boxes(keys, [&](const voxel::BoxKey& key, voxel::BoxOutcome outcome) {
        if (outcome.failure)
            missing.push_back(key);
        else
            take(key, std::move(outcome));
    });
    if (!missing.empty())
        m_helper.boxes(missing, take);
}

}  // namespace terravox::farm
