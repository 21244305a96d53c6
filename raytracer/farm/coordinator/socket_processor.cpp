#include "raytracer/farm/coordinator/socket_processor.hpp"

#include <algorithm>
#include <utility>

#include "raytracer/core/tiles/tile_codec.hpp"
#include "raytracer/farm/processors/processor_pool.hpp"
#include "raytracer/farm/wire/frames.hpp"

namespace terravox::farm {
namespace {

// Answers to leases that were withdrawn or given to others may arrive late; more than this is no
// accident.
constexpr std::size_t kMaxStrays = 10'000;

}  // namespace

SocketProcessor::SocketProcessor(std::shared_ptr<net::Link> link, std::string name,
                                 std::uint64_t picture, tiles::PixelContent content, int capacity,
                                 const blocks::BlockManager& blocks)
    : m_link(std::move(link)),
      m_name(std::move(name)),
      m_picture(picture),
      m_content(content),
      m_capacity(std::max(capacity, 1)),
      m_blocks(blocks) {}

void SocketProcessor::submit(tiles::RenderTile tile) {
    farm::Frame frame;
    farm::Task& task = *frame.mutable_task();
    task.set_picture(m_picture);
    {
        const std::lock_guard lock(m_mutex);
        if (m_closed)
            return;
        const std::uint64_t id = m_next_id++;
        m_leases.emplace(id, tile);
        *task.add_tiles() = to_frame(tile, id);
    }
    (void)m_link->send(std::move(frame));  // if the link has ended, its reader is notified
}

bool SocketProcessor::wait(std::chrono::milliseconds timeout) {
    std::unique_lock lock(m_mutex);
    return m_done.wait_for(lock, timeout, [&] { return has_answer(); });
}

std::optional<tiles::TileResult> SocketProcessor::take() {
    std::unique_lock lock(m_mutex);
    m_done.wait(lock, [&] { return has_answer(); });
    // Results from before the end of the link count; results of a worker that sent something
    // invalid do not.
    if (m_failure && (m_false || m_results.empty()))
        std::rethrow_exception(m_failure);
    if (m_cancelled || m_results.empty())
        return std::nullopt;
    tiles::TileResult result = std::move(m_results.front());
    m_results.pop_front();
    return result;
}

void SocketProcessor::withdraw(const tiles::RenderTile& tile) noexcept {
    try {
        farm::Frame frame;
        farm::Stop& stop = *frame.mutable_stop();
        stop.set_picture(m_picture);
        {
            const std::lock_guard lock(m_mutex);
            for (const auto& [id, leased] : m_leases)
                if (leased == tile)
                    stop.add_ids(id);
        }
        if (stop.ids_size() > 0)
            (void)m_link->send(std::move(frame));
    } catch (...) {
        m_link->abort();  // out of memory: the reader reports it
    }
}

void SocketProcessor::close() noexcept {
    const std::lock_guard lock(m_mutex);
    m_closed = true;
    m_done.notify_all();
}

void SocketProcessor::cancel() noexcept {
    {
        const std::lock_guard lock(m_mutex);
        m_closed = true;
        if (std::exchange(m_cancelled, true))
            return;
        m_leases.clear();
        m_done.notify_all();
    }
    try {
        farm::Frame frame;
        frame.mutable_stop()->set_picture(m_picture);
        (void)m_link->send(std::move(frame));
    } catch (...) {
        m_link->abort();
    }
}

void SocketProcessor::fail(std::exception_ptr failure) {
    const std::lock_guard lock(m_mutex);
    if (!m_failure)
        m_failure = std::move(failure);
    m_closed = true;
    m_done.notify_all();
}

void SocketProcessor::lost(const std::string& why) {
    fail(std::make_exception_ptr(processors::LostProcessor(m_name + ": " + why)));
}

void SocketProcessor::misbehaved(const std::string& what) {
    {
        const std::lock_guard lock(m_mutex);
        m_false = true;
    }
    fail(std::make_exception_ptr(processors::UntrustedProcessor(m_name + ": " + what)));
}

tiles::TileResult SocketProcessor::decoded(const std::string& bytes,
                                           const tiles::RenderTile& tile) const {
    const std::string name = "tile " + std::to_string(tile.index);
    const auto data = std::as_bytes(std::span(bytes));
    // Checked before any memory is allocated for pixels or holes.
    const tiles::TileHead head = tiles::read_tile_head(data, name);
    if (!(head.tile == tile))
        throw util::Error("it sent another tile than " + std::to_string(tile.index));
    if (head.content.layers != m_content.layers)
        throw util::Error("it sent " + name +
                          (m_content.layers ? " without layers" : " with layers"));
    if (head.content.bands != m_content.bands)
        throw util::Error("it sent " + name + " with " + std::to_string(head.content.bands) +
                          " bands; allowed: " + std::to_string(m_content.bands));
    if (const std::size_t known = m_blocks.hole_count(); head.holes > known)
        throw util::Error(name + " has " + std::to_string(head.holes) + " holes; allowed: the " +
                          std::to_string(known) +
                          " boxes that the coordinator could not load either");
    tiles::TileResult result = tiles::decode_tile(data, name);
    for (const voxel::BoxKey& key : result.holes)
        if (!m_blocks.is_hole(key))
            throw util::Error(name + " has a hole at box " + voxel::to_string(key) +
                              "; allowed: boxes that the coordinator could not load either");
    return result;
}

void SocketProcessor::done(const farm::Done& done) {
    tiles::RenderTile tile;
    {
        const std::lock_guard lock(m_mutex);
        if (m_cancelled)
            return;
        const auto lease = m_leases.find(done.id());
        if (lease == m_leases.end()) {
            if (++m_strays <= kMaxStrays)
                return;
            m_false = true;
            m_failure = std::make_exception_ptr(processors::UntrustedProcessor(
                m_name + ": it sends tiles that were not requested"));
            m_done.notify_all();
            return;
        }
        tile = lease->second;
        m_leases.erase(lease);
    }
    tiles::TileResult result;
    try {
        result = decoded(done.result(), tile);
    } catch (const util::Error& e) {
        misbehaved(e.what());
        return;
    }
    const std::lock_guard lock(m_mutex);
    m_results.push_back(std::move(result));
    m_done.notify_all();
}

void SocketProcessor::failed(const farm::Failed& failed) {
    std::optional<tiles::RenderTile> tile;
    {
        const std::lock_guard lock(m_mutex);
        if (const auto lease = m_leases.find(failed.id()); lease != m_leases.end())
            tile = lease->second;
    }
    const std::string why = m_name + " cannot render: " + failed.reason().substr(0, 400);
    tiles::RenderTile none;
    none.step = 0;  // the picture as a whole
    fail(std::make_exception_ptr(processors::FailingProcessor(why, tile.value_or(none))));
}

std::vector<tiles::RenderTile> SocketProcessor::list_tiles(const std::vector<std::uint64_t>& ids) {
    std::vector<tiles::RenderTile> out;
    const std::lock_guard lock(m_mutex);
    for (const std::uint64_t id : ids)
        if (const auto lease = m_leases.find(id); lease != m_leases.end()) {
            out.push_back(lease->second);
            m_leases.erase(lease);
        }
    return out;
}

}  // namespace terravox::farm
