#pragma once

#include "voxelserver/serve/map/column_top.hpp"

namespace terravox::test {

/// Every material has a colour of its own.
inline map::TopColours test_colours() {
    map::TopColours out;
    std::uint8_t i = 0;
    for (auto& entry : out.palette.entries) {
        entry.colour = {static_cast<std::uint8_t>(10 * i), static_cast<std::uint8_t>(255 - 9 * i),
                        static_cast<std::uint8_t>(40 + i)};
        ++i;
    }
    return out;
}

}  // namespace terravox::test
