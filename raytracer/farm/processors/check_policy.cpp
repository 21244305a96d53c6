#include "raytracer/farm/processors/check_policy.hpp"

#include <algorithm>

namespace terravox::processors {

bool CheckPolicy::is_due(PoolMember& member) noexcept {
    if (member.spec().trusted || m_check_every <= 0)
        return false;
    if (member.bands() == 0 || member.take_check_request())
        return true;
    return next_random() % static_cast<std::uint64_t>(m_check_every) == 0;
}

tiles::RenderTile CheckPolicy::choose_rows(tiles::RenderTile band) noexcept {
    const int grain = LeaseBook::kMinRows * band.step;
    const int first = band.y0 / grain;
    const int parts = (band.y1 + grain - 1) / grain - first;
    const auto choices = static_cast<std::uint64_t>(std::max(parts, 1));
    const int chosen = first + static_cast<int>(next_random() % choices);
    band.y0 = std::max(band.y0, chosen * grain);
    band.y1 = std::min(band.y1, (chosen + 1) * grain);
    return band;
}

// Ref: Marsaglia, "Xorshift RNGs", 2003.
std::uint64_t CheckPolicy::next_random() noexcept {
    m_random ^= m_random << 13;
    m_random ^= m_random >> 7;
    m_random ^= m_random << 17;
    return m_random;
}

}  // namespace terravox::processors
