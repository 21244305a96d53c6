#include "tests/bench/entries/scale_land.hpp"

#include <algorithm>
#include <cmath>

#include "tests/bench/entries/scale_noise.hpp"
#include "tests/bench/entries/scale_settled.hpp"

namespace terravox::bench {
namespace {

using voxel::floor_div;
using voxel::Material;
using voxel::Rgb8;

// Each use of a place has its own hashes.
constexpr std::uint64_t kHeightUse = 0x100;
constexpr std::uint64_t kWarpUse = 0x200;
constexpr std::uint64_t kFieldUse = 0x300;
constexpr std::uint64_t kShadeUse = 0x400;
constexpr std::uint64_t kWoodUse = 0x500;
constexpr std::uint64_t kTreeUse = 0x600;
constexpr std::int32_t kParcelX = 130;
constexpr std::int32_t kParcelZ = 90;
constexpr std::int32_t kTreeCell = 6;
constexpr int kWidestCrown = 5;  // columns from the trunk
constexpr double kRoadHalf = 3.2;
constexpr double kTreeLine = 172;
constexpr double kSnowLine = 196;

constexpr Rgb8 kCrops[] = {{0x8f, 0xa0, 0x4e}, {0xb9, 0xa8, 0x5c}, {0xc9, 0xb9, 0x7a},
                           {0x6c, 0x8a, 0x3e}, {0x8a, 0x6d, 0x4b}, {0x7c, 0x95, 0x49},
                           {0xa6, 0xa1, 0x55}, {0x77, 0x8f, 0x5a}};
constexpr std::size_t kPloughed = 4;
constexpr Rgb8 kRoofs[] = {
    {0xb0, 0x5a, 0x38}, {0xa2, 0x4c, 0x34}, {0xbd, 0x6f, 0x4a}, {0x74, 0x74, 0x78}};
constexpr std::size_t kSlate = 3;
constexpr Rgb8 kWalls[] = {
    {0xe2, 0xdc, 0xcc}, {0xd8, 0xc8, 0xa4}, {0xc9, 0xb0, 0x9a}, {0xea, 0xe6, 0xdf}};
constexpr Rgb8 kCrowns[] = {
    {0x3f, 0x6b, 0x2c}, {0x4b, 0x78, 0x33}, {0x35, 0x5c, 0x2e}, {0x5d, 0x80, 0x36}};
constexpr Material kLeaves = Material::kHighVegetation;
constexpr Rgb8 kBark{0x5b, 0x46, 0x32};

std::int16_t as_y(double y) noexcept {
    return static_cast<std::int16_t>(y);
}

/// A square piece of land while its columns are made: ground and buildings first, then trees on
/// top.
class Piece {
public:
    Piece(const Land& land, std::int32_t x0, std::int32_t z0, int side)
        : m_land(land),
          m_settled(land, x0, z0, side),
          m_x0(x0),
          m_z0(z0),
          m_side(side),
          m_columns(static_cast<std::size_t>(side) * static_cast<std::size_t>(side)) {}

    std::vector<LandColumn> make() {
        for (int z = 0; z < m_side; ++z)
            for (int x = 0; x < m_side; ++x)
                lay_ground(at(x, z), m_x0 + x, m_z0 + z);
        const auto cell = [](std::int32_t v) { return floor_div(v, kTreeCell); };
        for (std::int32_t z = cell(m_z0 - kWidestCrown);
             z <= cell(m_z0 + m_side - 1 + kWidestCrown); ++z)
            for (std::int32_t x = cell(m_x0 - kWidestCrown);
                 x <= cell(m_x0 + m_side - 1 + kWidestCrown); ++x)
                plant_tree(x, z);
        return std::move(m_columns);
    }

private:
    LandColumn& at(int x, int z) noexcept {
        return m_columns[static_cast<std::size_t>(z * m_side + x)];
    }
    [[nodiscard]] double noise(std::uint64_t use, std::int32_t x, std::int32_t z,
                               std::int32_t size) const noexcept {
        return value_noise(m_land.seed() + use, x, z, size);
    }

    void lay_ground(LandColumn& c, std::int32_t x, std::int32_t z) const noexcept {
        const double height = m_land.height(x, z);
        c.shade = static_cast<float>(1 + 0.10 * noise(kShadeUse, x, z, 30) +
                                     0.07 * noise(kShadeUse + 1, x, z, 3));
        c.ground = as_y(height);
        if (c.ground < Land::kWaterLevel) {
            // Deeper water would cost memory for voxels that hardly any light reaches: beds are
            // shallow.
            c.water = Land::kWaterLevel;
            c.ground =
                as_y(Land::kWaterLevel - std::fmin(4, 1 + 0.2 * (Land::kWaterLevel - height)));
        }
        if (c.ground <= Land::kWaterLevel)
            return look(c, Material::kSand, {0xcd, 0xbb, 0x8c});
        if (const LandHouse* house = m_settled.house_at(x, z, 0))
            build(c, *house, x, z);
        else if (m_settled.road_distance(x, z) < kRoadHalf)
            return look(c, Material::kRoad, {0x7d, 0x7b, 0x7c});
        const double line = height + 9 * noise(kWoodUse + 1, x, z, 60);
        if (line > kSnowLine)
            return look(c, Material::kSnow, {0xf0, 0xf3, 0xf6});
        if (line > kTreeLine)
            return look(c, Material::kRock, {0x86, 0x80, 0x76});
        if (wooded(x, z))
            return look(c, Material::kGround, {0x6a, 0x66, 0x40});
        if (m_settled.in_village(x, z))
            return look(c, Material::kGrass, {0x83, 0x99, 0x4f});
        paint_field(c, x, z);
    }

    static void look(LandColumn& c, Material material, Rgb8 colour) noexcept {
        c.surface = material;
        c.colour = colour;
    }

    /// Parcels with bent borders and rows, some with hedges.
    void paint_field(LandColumn& c, std::int32_t x, std::int32_t z) const noexcept {
        const auto bent = [&](std::int32_t v, std::uint64_t use) {
            return v + static_cast<std::int32_t>(35 * noise(use, x, z, 250));
        };
        const std::int32_t bx = bent(x, kWarpUse);
        const std::int32_t bz = bent(z, kWarpUse + 1);
        const std::int32_t px = floor_div(bx, kParcelX);
        const std::int32_t pz = floor_div(bz, kParcelZ);
        const std::uint64_t hash = place_hash(m_land.seed() + kFieldUse, px, pz);
        const auto crop = static_cast<std::size_t>(hash & 7);
        look(c, crop == kPloughed ? Material::kSoil : Material::kGrass, kCrops[crop]);
        const std::int32_t along = (hash & 8) != 0 ? bx : bz;
        if ((hash & 16) != 0)
            c.shade *= (along & 3) < 2 ? 0.95F : 1.04F;
        const bool border = bx == px * kParcelX || bz == pz * kParcelZ;
        if (border && unit_of(hash, 2) < 0.5 && c.runs[0].empty())
            c.runs[0] = {c.ground,
                         as_y(c.ground + 2),
                         Material::kLowVegetation,
                         Material::kLowVegetation,
                         {0x55, 0x78, 0x38},
                         {0x55, 0x78, 0x38}};
    }

    static void build(LandColumn& c, const LandHouse& house, std::int32_t x,
                      std::int32_t z) noexcept {
        const auto roof = static_cast<std::size_t>(house.hash >> 8 & 3);
        const auto wall = static_cast<std::size_t>(house.hash >> 10 & 3);
        const Material tiles = roof == kSlate ? Material::kGreyRoof : Material::kOrangeRoof;
        c.runs[0] = {c.ground,     as_y(std::max(c.ground + 2, house.roof(x, z))),
                     tiles,        Material::kWall,
                     kRoofs[roof], kWalls[wall]};
    }

    [[nodiscard]] bool wooded(std::int32_t x, std::int32_t z) const noexcept {
        return noise(kWoodUse, x, z, 640) + 0.35 * noise(kWoodUse + 2, x, z, 90) > 0.22 &&
               !m_settled.in_village(x, z);
    }

    void plant_tree(std::int32_t cell_x, std::int32_t cell_z) noexcept {
        const std::uint64_t hash = place_hash(m_land.seed() + kTreeUse, cell_x, cell_z);
        const std::int32_t x =
            cell_x * kTreeCell + static_cast<std::int32_t>(unit_of(hash, 0) * kTreeCell);
        const std::int32_t z =
            cell_z * kTreeCell + static_cast<std::int32_t>(unit_of(hash, 1) * kTreeCell);
        const double chance = unit_of(hash, 2);
        if (chance > 0.92 ||
            (chance > (m_settled.in_village(x, z) ? 0.12 : 0.006) && !wooded(x, z)))
            return;
        const double ground = m_land.height(x, z);
        const double line = ground + 9 * noise(kWoodUse + 1, x, z, 60);
        if (ground < Land::kWaterLevel + 1 || line > kTreeLine)
            return;
        if (m_settled.house_at(x, z, kWidestCrown) != nullptr ||
            m_settled.road_distance(x, z) < kRoadHalf + 2)
            return;
        const double tall =
            std::fmin(20, 6 + 12 * unit_of(hash, 3) * (line > kTreeLine - 25 ? 0.5 : 1) +
                              3 * (1 + noise(kWoodUse + 3, x, z, 120)));
        grow(x, z, static_cast<int>(ground), tall, survey::mix64(hash));
    }

    /// A trunk, and a crown that is the hull of an ellipsoid, up to four voxels thick: inside is
    /// what no pulse of a survey sees.
    void grow(std::int32_t x, std::int32_t z, int foot, double tall, std::uint64_t hash) noexcept {
        const double radius = std::fmin(kWidestCrown - 0.5, 1.3 + tall * 0.16);
        const double half = tall * 0.36;
        const double middle = foot + tall - half;
        const Rgb8 leaves = shaded(kCrowns[hash & 3], 0.85 + 0.3 * unit_of(hash, 1));
        for (std::int32_t dz = -kWidestCrown; dz <= kWidestCrown; ++dz)
            for (std::int32_t dx = -kWidestCrown; dx <= kWidestCrown; ++dx) {
                const std::int32_t px = x + dx - m_x0;
                const std::int32_t pz = z + dz - m_z0;
                const double out = (dx * dx + dz * dz) / (radius * radius);
                if (out >= 1 || px < 0 || pz < 0 || px >= m_side || pz >= m_side)
                    continue;
                LandColumn& c = at(px, pz);
                const double reach = half * std::sqrt(1 - out);
                const int top = std::max(c.ground + 2, static_cast<int>(std::ceil(middle + reach)));
                const int bottom = std::max(
                    {int{c.ground}, int{c.water}, static_cast<int>(middle - reach), top - 4});
                if (dx == 0 && dz == 0)
                    c.runs[0] = {c.ground,         as_y(bottom), Material::kTrunk,
                                 Material::kTrunk, kBark,        kBark};
                if (top > c.runs[1].y1)
                    c.runs[1] = {as_y(bottom), as_y(top), kLeaves, kLeaves, leaves, leaves};
            }
    }

    const Land& m_land;
    SettledLand m_settled;
    std::int32_t m_x0;
    std::int32_t m_z0;
    int m_side;
    std::vector<LandColumn> m_columns;
};

}  // namespace

double Land::height(std::int32_t x, std::int32_t z) const noexcept {
    const auto noise = [&](std::uint64_t use, std::int32_t px, std::int32_t pz, std::int32_t size) {
        return value_noise(m_seed + kHeightUse + use, px, pz, size);
    };
    // Bent land hides the grids that noise is made on.
    const std::int32_t bx = x + static_cast<std::int32_t>(210 * noise(8, x, z, 830));
    const std::int32_t bz = z + static_cast<std::int32_t>(210 * noise(9, x, z, 770));
    const double mountains = noise(0, bx, bz, 5000);
    const double hills = noise(1, bx, bz, 1700);
    const double medium = noise(2, bx, bz, 570);
    const double small = noise(3, bx, bz, 200);
    const double crest =
        1 - std::fabs(0.75 * medium + 0.35 * small);  // crests are sharp, valleys wide
    const double rough = 0.6 + 0.4 * hills;
    const double detail =
        rough * (2.8 * noise(5, x, z, 48) + 0.9 * noise(6, x, z, 17)) + 0.3 * noise(7, x, z, 7);
    const double low = 108 + 44 * mountains + 24 * hills + 7 * medium + 5 * small;
    return std::clamp(low + 78 * std::fmax(0, mountains + 0.3 * hills) * crest * crest + detail,
                      8.0, 225.0);
}

std::vector<LandColumn> Land::columns(std::int32_t x0, std::int32_t z0, int side) const {
    return Piece(*this, x0, z0, side).make();
}

}  // namespace terravox::bench
