#include "voxelserver/make/worlds/minecraft/block_appearance_cache.hpp"

#include <bit>

#include "voxelserver/make/worlds/minecraft/nbt.hpp"

namespace terravox::minecraft {
namespace {

// There are a few thousand appearances; a file of made-up blocks must not fill the memory.
constexpr std::size_t kMaxAppearances = std::size_t{1} << 17;
constexpr std::uint64_t kUnset = ~std::uint64_t{0};

}  // namespace

void palette_name(std::string_view entry, PaletteName& out) {
    NbtReader in(std::span(reinterpret_cast<const std::uint8_t*>(entry.data()), entry.size()));
    out.name = {};
    out.properties.clear();
    NbtField field;
    while (in.next(field)) {
        if (field.name == "Name" && field.type == NbtType::kString) {
            out.name = in.string();
        } else if (field.name == "Properties" && field.type == NbtType::kCompound) {
            NbtField property;
            while (in.next(property)) {
                if (property.type == NbtType::kString)
                    out.properties.push_back({property.name, in.string()});
                else
                    in.skip(property.type);
            }
        } else {
            in.skip(field.type);
        }
    }
    if (out.name.empty())
        throw NbtError("a palette entry without a Name");
}

BlockAppearanceCache::BlockAppearanceCache(BlockTable table)
    : m_table(std::move(table)),
      m_numbers(std::make_unique<std::atomic<std::uint64_t>[]>(kNumbers)) {
    for (std::size_t i = 0; i < kNumbers; ++i)
        m_numbers[i].store(kUnset, std::memory_order_relaxed);
}

void BlockAppearanceCache::of(std::span<const std::string_view> entries,
                              std::span<voxel::VoxelAttr> out) {
    std::size_t missing = 0;
    {
        const std::shared_lock lock(m_mutex);
        for (std::size_t i = 0; i < entries.size(); ++i) {
            const auto found = m_appearances.find(entries[i]);
            if (found != m_appearances.end())
                out[i] = found->second;
            else {
                out[i].reserved = 1;
                ++missing;
            }  // a marker; no appearance has this value
        }
    }
    if (missing == 0)
        return;
    for (std::size_t i = 0; i < entries.size(); ++i) {
        if (out[i].reserved == 0)
            continue;
        out[i] = find_appearance(entries[i]);
        const std::unique_lock lock(m_mutex);
        if (m_appearances.size() < kMaxAppearances)
            m_appearances.emplace(entries[i], out[i]);
    }
}

voxel::VoxelAttr BlockAppearanceCache::find_appearance(std::string_view entry) {
    PaletteName block;
    palette_name(entry, block);
    const BlockAppearance appearance = m_table.of(block.name, block.properties);
    if (!appearance.known)
        m_unknown.add(to_utf8(block.name));
    return appearance.to_attr();
}

voxel::VoxelAttr BlockAppearanceCache::of_number(std::uint16_t number) {
    const std::uint64_t kept = m_numbers[number].load(std::memory_order_relaxed);
    if (kept != kUnset)
        return std::bit_cast<voxel::VoxelAttr>(kept);
    const int id = number >> 4;
    const int data = number & 15;
    const BlockAppearance appearance = m_table.of_number(id, data);
    if (!appearance.known)
        m_unknown.add(std::to_string(id) + ":" + std::to_string(data));
    const voxel::VoxelAttr out = appearance.to_attr();
    m_numbers[number].store(std::bit_cast<std::uint64_t>(out), std::memory_order_relaxed);
    return out;
}

}  // namespace terravox::minecraft
