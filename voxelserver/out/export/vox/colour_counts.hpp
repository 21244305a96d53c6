#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "common/voxel/material.hpp"

namespace terravox::exports {

/// Counts colours in bounded memory: exactly as long as there are few, then in ever larger cells of
/// similar colours. The result does not depend on the order of counting.
class ColourCounts {
public:
    static constexpr std::size_t kMaxCells = std::size_t{1} << 16;

    struct Cell {
        std::uint32_t key = 0;  ///< key_of() of its colours
        std::uint64_t count = 0;
        voxel::Rgb8 mean;
    };

    void add(voxel::Rgb8 colour);
    /// All cells, by rising key.
    [[nodiscard]] std::vector<Cell> cells() const;
    /// The current cell of a colour.
    [[nodiscard]] std::uint32_t key_of(voxel::Rgb8 c) const noexcept {
        return static_cast<std::uint32_t>(c.r >> m_shift) << 16 |
               static_cast<std::uint32_t>(c.g >> m_shift) << 8 |
               static_cast<std::uint32_t>(c.b >> m_shift);
    }
    [[nodiscard]] std::size_t size() const noexcept { return m_sums.size(); }

private:
    struct Sum {
        std::uint64_t count = 0;
        std::uint64_t r = 0;
        std::uint64_t g = 0;
        std::uint64_t b = 0;
    };
    void coarsen();
    int m_shift = 0;  ///< low bits of a channel that cells ignore
    std::unordered_map<std::uint32_t, Sum> m_sums;
};

}  // namespace terravox::exports
