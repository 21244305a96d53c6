#pragma once

#include <cstddef>
#include <functional>
#include <mutex>
#include <shared_mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <unordered_set>
#include <utility>

#include "common/voxel/box.hpp"
#include "voxelserver/make/worlds/minecraft/blocks/block_table.hpp"

namespace terravox::luanti {

/// Material and colour of each node name; the table is searched once for each. Thread-safe. Names
/// that match no entry of the table are logged as warnings, once each, up to kLoggedNames.
class NodeAppearances {
public:
    static constexpr std::size_t kLoggedNames = 20;

    explicit NodeAppearances(minecraft::BlockTable table) : m_table(std::move(table)) {}

    [[nodiscard]] voxel::VoxelAttr of(std::string_view name);
    /// How many different names matched no entry of the table.
    [[nodiscard]] std::size_t unknown_names() const;

private:
    struct TextHash {
        using is_transparent = void;
        [[nodiscard]] std::size_t operator()(std::string_view text) const noexcept {
            return std::hash<std::string_view>{}(text);
        }
    };
    void log_unknown(std::string_view name);

    const minecraft::BlockTable m_table;
    std::shared_mutex m_appearances_mutex;  ///< guards m_appearances
    std::unordered_map<std::string, voxel::VoxelAttr, TextHash, std::equal_to<>> m_appearances;
    mutable std::mutex m_unknown_mutex;  ///< guards m_unknown
    std::unordered_set<std::string> m_unknown;
};

}  // namespace terravox::luanti
