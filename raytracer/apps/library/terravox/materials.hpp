#pragma once

#include <terravox/api.hpp>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace terravox {

struct Material {
    std::uint8_t number = 0;            ///< stays what it is in all versions
    std::string name;                   ///< "grass"
    std::array<std::uint8_t, 3> rgb{};  ///< its plain colour, sRGB
};

/// All materials, in the order of their numbers, from 0: air.
/// @throws Error when config/materials.toml cannot be read
[[nodiscard]] TERRAVOX_API std::vector<Material> materials();

}  // namespace terravox
