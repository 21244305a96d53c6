#include "voxelserver/gkot/gkot_blocks.hpp"

#include <array>

namespace terravox::gkot {
namespace {

constexpr std::uint32_t word(std::uint32_t id, std::uint32_t data = 0) {
    return data << 8 | id;
}

constexpr std::uint32_t kWool = 35, kLeaves = 18;
constexpr std::uint32_t kWhite = 0, kOrange = 1, kMagenta = 2, kGrey = 7, kLightGrey = 8;
constexpr std::uint32_t kOak = 0, kSpruce = 1;

// By the number of the material, without gaps: a new one has to be put in here (the size is
// checked).
constexpr std::array kWords = {
    word(0),                  // air
    word(1),                  // rock: stone; also all hidden voxels
    word(3),                  // soil: dirt
    word(3),                  // ground: dirt
    word(2),                  // grass
    word(2),                  // low vegetation: grass
    word(kLeaves, kSpruce),   // medium vegetation
    word(kLeaves, kOak),      // high vegetation
    word(kWool, kLightGrey),  // wall
    word(kWool, kLightGrey),  // roof
    word(kWool, kOrange),     // orange roof
    word(kWool, kLightGrey),  // grey roof
    word(kWool, kWhite),      // flat roof
    word(9),                  // water, still
    word(98),                 // bridge: stone bricks
    word(1),                  // road: stone
    word(kWool, kLightGrey),  // concrete
    word(13),                 // rail: the gravel under it, since rails are no full blocks
    word(101),                // wire: iron bars
    word(42),                 // tower: iron
    word(kWool, kGrey),       // object
    word(12),                 // sand
    word(80),                 // snow
    word(kWool, kMagenta),    // unknown: to be seen
    word(17),                 // trunk: oak log
    word(20),                 // glass
    word(79),                 // ice
    word(11),                 // lava, still
    word(89),                 // lamp: glowstone
    word(5),                  // wood: oak planks
    word(98),                 // masonry: stone bricks
    word(kWool, kWhite),      // plain
};
static_assert(kWords.size() == voxel::kMaterialCount);

}  // namespace

std::uint32_t block_word(voxel::Material material) noexcept {
    const auto index = static_cast<std::size_t>(material);
    return index < kWords.size() ? kWords[index]
                                 : kWords[static_cast<std::size_t>(voxel::Material::kUnknown)];
}

}  // namespace terravox::gkot
