#include "voxelserver/worlds/luanti/node_looks.hpp"

#include <spdlog/spdlog.h>

namespace terravox::luanti {
namespace {

// A game has some thousands of nodes; a file of invented names must not fill the memory.
constexpr std::size_t kMaxLooks = std::size_t{1} << 16;

voxel::VoxelAttr attr_of(const minecraft::BlockLook& look) noexcept {
    voxel::VoxelAttr out;
    out.material = look.material;
    if (look.has_colour) {
        out.flags = voxel::VoxelAttr::kHasColour;
        out.colour = look.colour;
    }
    return out;
}

}  // namespace

voxel::VoxelAttr NodeLooks::of(std::string_view name) {
    {
        const std::shared_lock lock(m_looks_mutex);
        if (const auto found = m_looks.find(name); found != m_looks.end())
            return found->second;
    }
    const minecraft::BlockLook look = m_table.of_full_name(name);
    if (!look.known)
        log_unknown(name);
    const voxel::VoxelAttr out = attr_of(look);
    const std::unique_lock lock(m_looks_mutex);
    if (m_looks.size() < kMaxLooks)
        m_looks.emplace(name, out);
    return out;
}

void NodeLooks::log_unknown(std::string_view name) {
    const std::lock_guard lock(m_unknown_mutex);
    if (m_unknown.size() >= kMaxLooks || !m_unknown.emplace(name).second)
        return;
    if (m_unknown.size() <= kLoggedNames)
        spdlog::warn(
            "no entry of config/blocks/luanti.toml fits the node {}: it is shown as "
            "material 'unknown'",
            name);
    if (m_unknown.size() == kLoggedNames)
        spdlog::warn("more unknown nodes are not logged one by one");
}

std::size_t NodeLooks::unknown_names() const {
    const std::lock_guard lock(m_unknown_mutex);
    return m_unknown.size();
}

}  // namespace terravox::luanti
