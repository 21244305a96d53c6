#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/voxel/box.hpp"

namespace terravox::test {

/// A record of a batch, written from docs/formats/http.md alone.
inline std::string record(const voxel::BoxKey& key, std::uint32_t status,
                          std::string_view payload) {
    std::string out;
    for (const std::uint32_t word :
         {static_cast<std::uint32_t>(key.level), static_cast<std::uint32_t>(key.bx),
          static_cast<std::uint32_t>(key.by), static_cast<std::uint32_t>(key.bz), status,
          static_cast<std::uint32_t>(payload.size())})
        for (int byte = 0; byte < 4; ++byte)
            out += static_cast<char>(word >> (8 * byte) & 255);
    return out.append(payload);
}

inline std::string last_record(std::size_t boxes) {
    return record({-1, static_cast<std::int32_t>(boxes), 0, 0}, 0, "");
}

}  // namespace terravox::test
