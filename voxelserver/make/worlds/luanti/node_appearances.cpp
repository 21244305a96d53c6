#include "voxelserver/make/worlds/luanti/node_appearances.hpp"
#include "common/util/log.hpp"

namespace terravox::luanti {
namespace {

// A game has some thousands of nodes; a file of made-up names must not fill the memory.
constexpr std::size_t kMaxAppearances = std::size_t{1} << 16;

voxel::VoxelAttr attr_of(const minecraft::BlockAppearance& appearance) noexcept {
    voxel::VoxelAttr out;
    out.material = appearance.material;
    if (appearance.has_colour) {
        out.flags = voxel::VoxelAttr::kHasColour;
        out.colour = appearance.colour;
    }
    return out;
}

}  // namespace

voxel::VoxelAttr NodeAppearances::of(std::string_view name) {
    {
        const std::shared_lock lock(m_appearances_mutex);
        if (const auto found = m_appearances.find(name); found != m_appearances.end())
            return found->second;
    }
    const minecraft::BlockAppearance appearance = m_table.of_full_name(name);
    if (!appearance.known)
        log_unknown(name);
    const voxel::VoxelAttr out = attr_of(appearance);
    const std::unique_lock lock(m_appearances_mutex);
    if (m_appearances.size() < kMaxAppearances)
        m_appearances.emplace(name, out);
    return out;
}

void NodeAppearances::log_unknown(std::string_view name) {
    const std::lock_guard lock(m_unknown_mutex);
    if (m_unknown.size() >= kMaxAppearances || !m_unknown.emplace(name).second)
        return;
    if (m_unknown.size() <= kLoggedNames)
        util::log_warn(
            "no entry of config/blocks/luanti.toml fits the node {}: it is shown as "
            "material 'unknown'",
            name);
    if (m_unknown.size() == kLoggedNames)
        util::log_warn("more unknown nodes are not logged one by one");
}

std::size_t NodeAppearances::unknown_names() const {
    const std::lock_guard lock(m_unknown_mutex);
    return m_unknown.size();
}

}  // namespace terravox::luanti
