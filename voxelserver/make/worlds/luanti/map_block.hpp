#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "voxelserver/make/worlds/luanti/unpack.hpp"

namespace terravox::luanti {

inline constexpr std::size_t kBlockNodes = 16 * 16 * 16;
/// Versions of the serialization that are read: those of the game since 0.4.0 that name their nodes
/// in each block.
inline constexpr int kOldestVersion = 25;
inline constexpr int kNewestVersion = 29;

/// A map block as it is stored, in the game's axes.
struct MapBlock {
    static constexpr std::size_t kMaxNameBytes = 256;

    struct Name {
        std::uint16_t id = 0;
        std::string_view name;  ///< "default:stone"; any bytes
    };
    int version = 0;
    std::array<std::uint16_t, kBlockNodes> ids{};  ///< of node (x, y, z): x + 16 y + 256 z
    std::vector<Name> names;                       ///< by rising id, each id once
};

/// Reads map blocks one after the other. Not thread-safe: one for each thread.
class MapBlockReader {
public:
    /// @param blob must live while the names are used
    /// @return valid until the next call
    /// @throws Error: why the block cannot be used; none of its nodes may then be used
    const MapBlock& read(std::span<const std::uint8_t> blob);

private:
    Unpacker m_unpacker;
    MapBlock m_block;
};

}  // namespace terravox::luanti
