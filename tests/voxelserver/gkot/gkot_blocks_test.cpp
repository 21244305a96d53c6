#include "voxelserver/gkot/gkot_blocks.hpp"
#include "tests/catch.hpp"

using namespace terravox;
using voxel::Material;

TEST_CASE("blocks of the first system keep their numbers and data", "[gkot][blocks]") {
    struct Case {
        Material material;
        std::uint32_t word;
    };
    const auto c = GENERATE(values<Case>({
        {Material::kAir, 0x000},
        {Material::kGround, 0x003},
        {Material::kLowVegetation, 0x002},
        {Material::kMediumVegetation, 0x112},
        {Material::kHighVegetation, 0x012},
        {Material::kWall, 0x823},
        {Material::kRoof, 0x823},
        {Material::kGreyRoof, 0x823},
        {Material::kConcrete, 0x823},
        {Material::kOrangeRoof, 0x123},
        {Material::kFlatRoof, 0x023},
        {Material::kRoad, 0x001},
        {Material::kWater, 0x009},
    }));
    DYNAMIC_SECTION(voxel::material_name(c.material)) {
        CHECK(gkot::block_word(c.material) == c.word);
    }
}

TEST_CASE("every material but air is a block, within the bits that words have", "[gkot][blocks]") {
    for (int i = 1; i < 256; ++i) {
        INFO("material " << i);
        const std::uint32_t word = gkot::block_word(static_cast<Material>(i));
        CHECK((word & 0xff) != 0);
        CHECK(word <= 0xfff);
    }
    CHECK(gkot::block_word(Material::kUnknown) == 0x223);
    CHECK(gkot::block_word(static_cast<Material>(200)) == gkot::block_word(Material::kUnknown));
}
