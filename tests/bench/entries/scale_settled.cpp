#include "tests/bench/entries/scale_settled.hpp"

#include <algorithm>
#include <cmath>

#include "tests/bench/entries/scale_noise.hpp"

namespace terravox::bench {
namespace {

constexpr std::uint64_t kVillageUse = 0x700, kLotUse = 0x800,
                        kBendUse = 0x900;  // each use of a place has its own hashes
constexpr std::int32_t kVillageCell = 900;
constexpr std::int32_t kLotCell = 23;
constexpr std::int32_t kMargin = 40;
constexpr int kMaxBend = 24;
constexpr double kHouseToRoad = 10.5;

}  // namespace

SettledLand::SettledLand(const Land& land, std::int32_t x0, std::int32_t z0, int side)
    : m_land(land) {
    const auto reaches = [&](std::int32_t xa, std::int32_t za, std::int32_t xb, std::int32_t zb,
                             int around) {
        return std::max(xa, xb) + around >= x0 - kMargin &&
               std::min(xa, xb) - around <= x0 + side + kMargin &&
               std::max(za, zb) + around >= z0 - kMargin &&
               std::min(za, zb) - around <= z0 + side + kMargin;
    };
    const std::int32_t cx = voxel::floor_div(x0, kVillageCell);
    const std::int32_t cz = voxel::floor_div(z0, kVillageCell);
    for (std::int32_t z = cz - 2; z <= cz + 2; ++z)
        for (std::int32_t x = cx - 2; x <= cx + 2; ++x) {
            const auto here = village(x, z);
            if (!here)
                continue;
            if (reaches(here->x, here->z, here->x, here->z, here->radius))
                m_villages.push_back(*here);
            for (const auto& other : {village(x + 1, z), village(x, z + 1)})
                if (other && reaches(here->x, here->z, other->x, other->z, kMaxBend))
                    m_roads.push_back(
                        {double(here->x), double(here->z), double(other->x), double(other->z)});
        }
    if (m_villages.empty())
        return;
    for (std::int32_t z = voxel::floor_div(z0 - kMargin, kLotCell);
         z <= voxel::floor_div(z0 + side + kMargin, kLotCell); ++z)
        for (std::int32_t x = voxel::floor_div(x0 - kMargin, kLotCell);
             x <= voxel::floor_div(x0 + side + kMargin, kLotCell); ++x)
            if (const auto found = house(x, z))
                m_houses.push_back(*found);
}

std::optional<SettledLand::Village> SettledLand::village(std::int32_t cell_x,
                                                         std::int32_t cell_z) const noexcept {
    const std::uint64_t hash = place_hash(m_land.seed() + kVillageUse, cell_x, cell_z);
    Village out;
    out.x = cell_x * kVillageCell + 250 + static_cast<std::int32_t>(unit_of(hash, 0) * 400);
    out.z = cell_z * kVillageCell + 250 + static_cast<std::int32_t>(unit_of(hash, 1) * 400);
    out.radius = 110 + static_cast<std::int32_t>(unit_of(hash, 2) * 130);
    const double h = m_land.height(out.x, out.z);
    return unit_of(hash, 3) < 0.75 && h > Land::kWaterLevel + 2 && h < 165 ? std::optional(out)
                                                                           : std::nullopt;
}

std::optional<double> SettledLand::place_in_village(std::int32_t x, std::int32_t z) const noexcept {
    for (const Village& v : m_villages) {
        const double dx = x - v.x;
        const double dz = z - v.z;
        const double place = (dx * dx + dz * dz) / (double(v.radius) * v.radius);
        if (place < 1)
            return place;
    }
    return std::nullopt;
}

bool SettledLand::in_village(std::int32_t x, std::int32_t z) const noexcept {
    return place_in_village(x, z).has_value();
}

double SettledLand::road_distance(std::int32_t x, std::int32_t z) const noexcept {
    double nearest = 1e18;
    if (m_roads.empty())
        return nearest;
    // The land is bent, not the roads.
    const double px = x + kMaxBend * value_noise(m_land.seed() + kBendUse, x, z, 180);
    const double pz = z + kMaxBend * value_noise(m_land.seed() + kBendUse + 1, x, z, 180);
    for (const Road& road : m_roads) {
        const double dx = road.x1 - road.x0;
        const double dz = road.z1 - road.z0;
        const double along = std::clamp(
            ((px - road.x0) * dx + (pz - road.z0) * dz) / (dx * dx + dz * dz + 1), 0.0, 1.0);
        const double ex = px - road.x0 - along * dx;
        const double ez = pz - road.z0 - along * dz;
        nearest = std::min(nearest, ex * ex + ez * ez);
    }
    return std::sqrt(nearest);
}

std::optional<LandHouse> SettledLand::house(std::int32_t lot_x, std::int32_t lot_z) const noexcept {
    const std::uint64_t hash = place_hash(m_land.seed() + kLotUse, lot_x, lot_z);
    LandHouse out;
    out.x = lot_x * kLotCell + kLotCell / 2 + static_cast<std::int32_t>(unit_of(hash, 1) * 5) - 2;
    out.z = lot_z * kLotCell + kLotCell / 2 + static_cast<std::int32_t>(unit_of(hash, 2) * 5) - 2;
    out.hash = survey::mix64(hash);
    const auto place = place_in_village(out.x, out.z);
    if (!place || unit_of(hash, 0) > 0.95 - 0.55 * *place)
        return std::nullopt;
    if ((out.hash & 1) != 0)
        std::swap(out.half_x, out.half_z);
    const double ground = m_land.height(out.x, out.z);
    if (ground < Land::kWaterLevel + 2 || road_distance(out.x, out.z) < kHouseToRoad)
        return std::nullopt;
    out.eaves = static_cast<int>(ground) + 3 + static_cast<int>(unit_of(out.hash, 1) * 4);
    return out;
}

const LandHouse* SettledLand::house_at(std::int32_t x, std::int32_t z, int around) const noexcept {
    const auto found = std::find_if(m_houses.begin(), m_houses.end(),
                                    [&](const LandHouse& h) { return h.covers(x, z, around); });
    return found == m_houses.end() ? nullptr : &*found;
}

}  // namespace terravox::bench
