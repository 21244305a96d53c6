#include "raytracer/farm/processors/result_queue.hpp"

#include <utility>

namespace terravox::processors {

bool ResultQueue::begins_pass(const tiles::RenderTile& tile) const noexcept {
    return m_pass != pass_of(tile);
}

void ResultQueue::expect(const tiles::RenderTile& tile) {
    if (begins_pass(tile))
        m_taken.clear();
    m_pass = pass_of(tile);
    ++m_first_left;
}

void ResultQueue::push(tiles::TileResult&& result) {
    result.again = m_taken.contains(result.tile.index);
    // Tiles that are returned again are first, as the last of the others may have to wait for them.
    if (result.again)
        m_ready.push_front(std::move(result));
    else
        m_ready.push_back(std::move(result));
}

bool ResultQueue::can_take(bool checks_open) const noexcept {
    if (m_ready.empty())
        return false;
    return m_ready.front().again || m_first_left > 1 || (!checks_open && m_again_left == 0);
}

tiles::TileResult ResultQueue::take() {
    tiles::TileResult result = std::move(m_ready.front());
    m_ready.pop_front();
    if (m_taken.insert(result.tile.index).second)
        --m_first_left;
    else
        --m_again_left;
    return result;
}

void ResultQueue::invalidate(std::uint32_t index) {
    // If the tile was not taken, the new result replaces the old one.
    const auto is_it = [&](const tiles::TileResult& r) { return r.tile.index == index; };
    if (std::erase_if(m_ready, is_it) > 0)
        return;
    ++m_again_left;
    m_invalidated.push_back(index);
}

std::vector<std::uint32_t> ResultQueue::take_invalidated() {
    return std::exchange(m_invalidated, {});
}

}  // namespace terravox::processors
