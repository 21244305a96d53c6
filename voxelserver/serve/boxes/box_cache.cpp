#include "voxelserver/serve/boxes/box_cache.hpp"

#include <xxhash.h>
#include <algorithm>
#include <optional>

#include "common/thread/start_threads.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/box.hpp"
#include "common/voxel/box_builder.hpp"

namespace terravox::boxes {

void PrefetchQueue::add(const std::vector<voxel::BoxKey>& keys,
                        const std::function<bool(const voxel::BoxKey&)>& wanted) {
    const std::lock_guard lock(m_mutex);
    if (m_closed)
        return;
    for (const voxel::BoxKey& key : keys)
        if (wanted(key) && m_queued.insert(key).second)
            m_keys.push_front(key);
    while (m_keys.size() > m_max_keys) {
        m_queued.erase(m_keys.back());
        m_keys.pop_back();
    }
    m_changed.notify_all();
}

std::optional<voxel::BoxKey> PrefetchQueue::take() {
    std::unique_lock lock(m_mutex);
    m_changed.wait(lock, [&] { return m_closed || !m_keys.empty(); });
    if (m_closed)
        return std::nullopt;
    const voxel::BoxKey key = m_keys.front();
    m_keys.pop_front();
    m_queued.erase(key);
    return key;
}

void PrefetchQueue::close() {
    {
        const std::lock_guard lock(m_mutex);
        m_closed = true;
    }
    m_changed.notify_all();
}

std::size_t PrefetchQueue::size() const {
    const std::lock_guard lock(m_mutex);
    return m_keys.size();
}

namespace {

// Length of the prefetch queue: the oldest requests are dropped.
constexpr std::size_t kMaxAhead = 256;

CompressedBoxPtr to_compressed_box(std::uint64_t checksum, std::shared_ptr<const std::string> frame,
                                   const voxel::InputExtent& reach) {
    const std::uint64_t hash = frame ? XXH3_64bits(frame->data(), frame->size()) : 0;
    return std::make_shared<const CompressedBox>(
        CompressedBox{checksum, hash, std::move(frame), reach});
}

}  // namespace

BoxCache::BoxCache(voxel::ProvenanceWorld& world, util::StageTimes& times,
                   const BoxCacheOptions& options)
    : m_world(world),
      m_times(times),
      m_admission(std::max(options.makers, 1), std::max(options.queue, 0)),
      m_slots(std::max(options.max_requests, 1), "wait for a box", "requests wait already"),
      m_downsample(options.downsample),
      m_ahead_on(options.ahead),
      m_memory(options.memory_bytes),
      m_disk(options.file.empty()
                 ? nullptr
                 : std::make_unique<DiskCache>(
                       options.file, options.disk_bytes,
                       [&world](const voxel::InputExtent& r) { return world.fingerprint(r); })),
      m_prefetch_queue(kMaxAhead) {
    // Half as many threads as makers, so that requests in the meantime still find an idle core.
    if (!options.ahead)
        return;
    const auto count = static_cast<std::size_t>(std::max(options.makers / 2, 1));
    thread::start_threads(
        m_threads, count, [this] { prefetch_queued(); }, [this] { request_stop(); });
}

BoxCache::~BoxCache() {
    close();
}

void BoxCache::request_stop() {
    m_admission.close();
    m_prefetch_queue.close();
}

void BoxCache::close() {
    request_stop();
    const std::lock_guard lock(m_join_mutex);
    for (std::thread& t : m_threads)
        if (t.joinable())
            t.join();
}

CompressedBoxPtr BoxCache::air_outside_bounds(const voxel::BoxKey& key) const {
    // There is nothing solid outside the bounds. Answered without the cache, which requests for all
    // of space would otherwise flush.
    const voxel::VoxelBounds& bounds = m_world.info().bounds;
    if (!bounds.empty() && voxel::boxes_over(bounds, key.level).contains(key))
        return nullptr;
    return to_compressed_box(0, nullptr, footprint(key));
}

CompressedBoxPtr BoxCache::find_or_make(const voxel::BoxKey& key) {
    if (auto cached = m_memory.hit(key))
        return cached;
    const Slots::Permit permit(m_slots);
    return find_or_make(key, Origin::kCaller);
}

CompressedBoxPtr BoxCache::find_or_make_when_idle(const voxel::BoxKey& key) {
    if (auto cached = peek(key))
        return cached;
    // Its children first, each when the machine is idle.
    if (key.level > 0 && m_downsample)
        for (int i = 0; i < 8; ++i)
            if (!find_or_make_when_idle(voxel::Pyramid::child(key, i)))
                return nullptr;
    const AdmissionControl::PrefetchPermit permit(m_admission);
    return permit ? find_or_make(key, Origin::kPrefetch) : nullptr;
}

CompressedBoxPtr BoxCache::find(const voxel::BoxKey& key) {
    if (auto cached = find_in_memory(key))
        return cached;
    auto box = read_from_disk(key);
    if (box)
        m_memory.put(key, box, box->memory_bytes());
    return box;
}

CompressedBoxPtr BoxCache::peek(const voxel::BoxKey& key) {
    auto cached = find_in_memory(key);
    return cached ? cached : read_from_disk(key);
}

CompressedBoxPtr BoxCache::find_or_make(const voxel::BoxKey& key, Origin origin) {
    if (auto air = air_outside_bounds(key))
        return air;
    bool fresh = false;
    auto out = m_memory.get(
        key,
        [&] {
            fresh = true;
            auto on_disk = read_from_disk(key);
            return on_disk ? on_disk : make_and_store(key, origin);
        },
        [](const CompressedBoxPtr& box) { return box->memory_bytes(); });
    if (fresh && m_listener)
        m_listener(key);
    return out;
}

CompressedBoxPtr BoxCache::find_in_memory(const voxel::BoxKey& key) {
    auto air = air_outside_bounds(key);
    return air ? air : m_memory.find(key);
}

CompressedBoxPtr BoxCache::read_from_disk(const voxel::BoxKey& key) {
    if (!m_disk)
        return nullptr;
    const util::StageTimes::Scope timed(m_times, "box cache");
    const auto item = m_disk->find(Kind::kBox, key);
    return item ? to_compressed_box(item->tag, item->bytes, item->reach) : nullptr;
}

voxel::BoxWithInputs BoxCache::make_box(const voxel::BoxKey& key, Origin origin) {
    if (key.level == 0 || !m_downsample)
        return m_world.box_with_inputs(key);
    voxel::BoxWithInputs out;
    out.reach = footprint(key);
    if (m_world.column(key.level, key.bx, key.bz).empty())
        return out;
    const auto children = voxel::Pyramid::children(key, [&](const voxel::BoxKey& child) {
        const auto compressed =
            find_or_make(child, origin == Origin::kPrefetch ? origin : Origin::kParent);
        out.reach.add(compressed->reach);
        return decompress(*compressed, child);
    });
    std::optional<AdmissionControl::Permit> permit;
    if (origin != Origin::kPrefetch)
        permit.emplace(m_admission);
    const util::StageTimes::Scope timed(m_times, "downsample");
    out.box = voxel::downsample(key, children);
    return out;
}

CompressedBoxPtr BoxCache::make_compressed(const voxel::BoxKey& key, Origin origin) {
    voxel::BoxWithInputs made = make_box(key, origin);
    made.reach.add(footprint(key));
    std::shared_ptr<const std::string> frame;
    if (made.box) {
        const util::StageTimes::Scope timed(m_times, "compression");
        const auto bytes = voxel::compress(*made.box);
        frame = std::make_shared<const std::string>(reinterpret_cast<const char*>(bytes.data()),
                                                    bytes.size());
    }
    return to_compressed_box(made.box ? made.box->checksum() : 0, std::move(frame), made.reach);
}

CompressedBoxPtr BoxCache::make_and_store(const voxel::BoxKey& key, Origin origin) {
    std::optional<AdmissionControl::Permit> permit;
    // A box that waits for its children must not occupy a slot that they need.
    if (origin != Origin::kPrefetch && (key.level == 0 || !m_downsample))
        permit.emplace(m_admission);
    const auto make = [&] { return make_compressed(key, origin); };
    const auto no_thread = []() -> CompressedBoxPtr {
        throw OverloadedError("make a box: the system has no thread for it");
    };
    CompressedBoxPtr box;
    try {
        // Callers may be threads with little stack: those of the web server.
        box = origin == Origin::kCaller ? thread::on_new_thread(make, no_thread) : make();
    } catch (const OverloadedError&) {
        throw;
    } catch (...) {
        ++m_failed;
        throw;
    }
    ++m_made;
    if (origin == Origin::kPrefetch)
        ++m_made_ahead;
    if (m_disk)
        m_disk->put(
            Kind::kBox, key, {box->checksum, box->frame, box->reach},
            origin == Origin::kPrefetch ? DiskCache::WhenFull::kWait : DiskCache::WhenFull::kDrop);
    if (origin == Origin::kCaller)
        queue_neighbours(key);
    return box;
}

std::shared_ptr<const voxel::Box> BoxCache::decompress(const CompressedBox& box,
                                                       const voxel::BoxKey& key) {
    return box.air() ? nullptr
                     : voxel::decompress_box(std::as_bytes(std::span(*box.frame)),
                                             "box " + voxel::to_string(key));
}

// Prefetches the boxes above and below it, which share nearly all of its work, and its neighbours.
void BoxCache::queue_neighbours(const voxel::BoxKey& key) {
    if (!m_ahead_on)
        return;
    std::vector<voxel::BoxKey> wanted;
    // No world extends so far that this overflows: air_outside_bounds() has handled such keys
    // before.
    for (int dz = -1; dz <= 1; ++dz)
        for (int dx = -1; dx <= 1; ++dx)
            wanted.push_back({key.level, key.bx + dx, key.by, key.bz + dz});
    const voxel::ColumnExtent column = m_world.column(key.level, key.bx, key.bz);
    for (std::int32_t by = column.by_begin; by < column.by_end; ++by)
        wanted.push_back({key.level, key.bx, by, key.bz});
    m_prefetch_queue.add(wanted, [&](const voxel::BoxKey& next) {
        return next != key && !air_outside_bounds(next) && !m_memory.holds(next);
    });
}

void BoxCache::prefetch_queued() {
    while (const std::optional<voxel::BoxKey> key = m_prefetch_queue.take()) {
        try {
            (void)find_or_make_when_idle(*key);
        } catch (const std::exception& e) {
            // A request for it will report the error.
            util::log_debug("make box {} ahead: {}", voxel::to_string(*key), e.what());
        }
    }
}

BoxCache::Stats BoxCache::stats() const {
    Stats out;
    out.memory = m_memory.stats();
    out.admission = m_admission.counts();
    out.made = m_made;
    out.made_ahead = m_made_ahead;
    out.failed = m_failed;
    out.ahead_waiting = m_prefetch_queue.size();
    return out;
}

std::vector<voxel::BoxKey> BoxCache::in_memory(int level, std::size_t max_keys) const {
    std::vector<voxel::BoxKey> out;
    m_memory.each_key([&](const voxel::BoxKey& key) {
        if (key.level == level && out.size() < max_keys)
            out.push_back(key);
    });
    std::sort(out.begin(), out.end());
    return out;
}

}  // namespace terravox::boxes
