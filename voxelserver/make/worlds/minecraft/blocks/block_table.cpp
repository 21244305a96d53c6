#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"

#include <algorithm>
#include <bit>

namespace terravox::minecraft {
namespace {

std::string_view without_namespace(std::string_view name) noexcept {
    const auto colon = name.find(':');
    return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

bool all_hold(const std::vector<Condition>& conditions, Properties properties) noexcept {
    return std::all_of(conditions.begin(), conditions.end(),
                       [&](const Condition& c) { return c.holds(properties); });
}

}  // namespace

BlockAppearance BlockTable::chosen(const Candidate& candidate, Properties properties) const {
    BlockAppearance appearance = candidate.appearance;
    if (candidate.fixed || !m_drowned[static_cast<std::size_t>(appearance.material)])
        return appearance;
    const auto drowned = [](const Property& p) {
        return p.name == "waterlogged" && p.value == "true";
    };
    if (std::any_of(properties.begin(), properties.end(), drowned))
        appearance = {voxel::Material::kWater, false, {}, true};
    return appearance;
}

BlockAppearance BlockTable::appearance_of(std::string_view name, Properties properties) const {
    if (const auto found = m_names.find(name); found != m_names.end())
        for (const Candidate& candidate : found->second)
            if (all_hold(candidate.conditions, properties))
                return chosen(candidate, properties);
    for (const auto& [pattern, candidate] : m_wildcards)
        if (fits(pattern, name) && all_hold(candidate.conditions, properties))
            return chosen(candidate, properties);
    return {};
}

BlockAppearance BlockTable::of(std::string_view name, Properties properties) const {
    name = without_namespace(name);
    const auto renamed = m_renamed.find(name);
    if (renamed == m_renamed.end())
        return appearance_of(name, properties);
    std::vector<Property> all(properties.begin(), properties.end());
    for (const Condition& c : renamed->second.conditions)
        all.push_back({c.property, c.values.front()});
    return appearance_of(renamed->second.name, all);
}

BlockAppearance BlockTable::of_number(int id, int data) const {
    if (id < 0 || id >= kNumbers)
        return {};
    return m_number_appearances[static_cast<std::size_t>(id * kData + (data & (kData - 1)))];
}

std::string BlockTable::name_of_number(int id, int data) const {
    data &= kData - 1;
    if (id < 0 || id >= kNumbers || m_number_names[static_cast<std::size_t>(id)].empty())
        return std::to_string(id) + ":" + std::to_string(data);
    const auto& names = m_number_names[static_cast<std::size_t>(id)];
    const std::size_t place = static_cast<std::size_t>(data) & (std::bit_ceil(names.size()) - 1);
    return names[place < names.size() ? place : 0];
}

void BlockTable::overlay(const std::map<std::string, voxel::Material>& blocks) {
    for (const auto& [full_name, material] : blocks) {
        const std::string name(without_namespace(full_name));
        Candidate candidate;
        candidate.appearance = of(name, {});
        candidate.appearance.material = material;
        candidate.appearance.known = true;
        candidate.fixed = true;
        m_renamed.erase(name);
        m_names[name] = {candidate};
    }
}

}  // namespace terravox::minecraft
