#include "voxelserver/make/worlds/procedural/terrain.hpp"

#include <algorithm>
#include <cmath>

#include "voxelserver/make/worlds/procedural/noise.hpp"

namespace terravox::procedural {
namespace {

enum Field {
    kContinent,
    kMountains,
    kHilliness,
    kTemperature,
    kMoisture,
    kRiver,
    kWarpX,
    kWarpZ,
    kHills,
    kRidges,
    kRiverBend,
    kPlace,
    kCrags
};

double octaves(std::uint64_t seed, double x, double z, int count) noexcept {
    double sum = 0;
    double height = 1;
    double all = 0;
    for (int i = 0; i < count; ++i) {
        sum += height * simplex(seed + static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ULL, x, z);
        all += height;
        height *= 0.5;
        x *= 2;
        z *= 2;
    }
    return sum / all;
}

constexpr double kRidgeLength = 2.4;  // of the first octave of ridges to that of hills

// How much of an octave remains among voxels of a size: all above four voxels, nothing below two.
double find_kept(double wavelength, double voxel) noexcept {
    return voxel <= 1 ? 1 : smooth_step(2, 4, wavelength / voxel);
}

// The bare continent as a function of its noise: deep sea, shelf, beach, plain, highland.
double shore_profile(double c) noexcept {
    constexpr double kShore = -0.06;
    if (c < kShore)
        return -0.02 - 0.48 * smooth_step(0.02, 0.75, kShore - c) -
               0.12 * std::min((kShore - c) / 0.25, 1.0);
    return -0.02 + 0.045 * std::min((c - kShore) / 0.09, 1.0) +
           0.075 * smooth_step(0.03, 0.7, c - kShore);
}

}  // namespace

Terrain::Terrain(const Settings& settings) : m_settings(settings) {
    check(settings);
    for (int i = 0; i < 16; ++i)
        m_seeds[i] = make_seed(settings.seed, i);
    find_origin();
}

Region Terrain::region(double x, double z) const noexcept {
    const double f = m_settings.frequency;
    x = (x + m_origin_x) * f;
    z = (z + m_origin_z) * f;
    Region out;
    const double bend_x = simplex(m_seeds[kWarpX], x * 0.5, z * 0.5);
    const double bend_z = simplex(m_seeds[kWarpZ], x * 0.5, z * 0.5);
    out.warp_x = bend_x * 0.22 / f;
    out.warp_z = bend_z * 0.22 / f;
    const double wide_x = x + bend_x * 0.35;
    const double wide_z = z + bend_z * 0.35;
    const double continent = octaves(m_seeds[kContinent], wide_x / 5, wide_z / 5, 4) * 1.5 + 0.12;
    out.land = shore_profile(continent);
    out.inland = smooth_step(-0.04, 0.22, continent);
    out.mountains =
        smooth_step(0.02, 0.55, octaves(m_seeds[kMountains], wide_x / 2.8, wide_z / 2.8, 2)) *
        smooth_step(0, 0.3, continent);
    out.hills =
        (0.025 + 0.16 * smooth_step(-0.25, 0.7, simplex(m_seeds[kHilliness], x / 2.2, z / 2.2))) *
        (0.3 + 0.7 * out.inland);
    out.temperature = 0.5 + 0.55 * octaves(m_seeds[kTemperature], wide_x / 7, wide_z / 7, 2);
    out.moisture = 0.5 + 0.62 * octaves(m_seeds[kMoisture], wide_x / 4.5, wide_z / 4.5, 2);
    const double bend = 0.12 * simplex(m_seeds[kRiverBend], x * 1.4, z * 1.4);
    const double river = octaves(m_seeds[kRiver], wide_x / 3 + bend, wide_z / 3 - bend, 2) *
                         (3 * 0.15 / f);  // columns from its middle, about
    out.river = std::clamp(river / 60, -1.0, 1.0);
    return out;
}

double Terrain::hills(double x, double z, double voxel, double& smooth) const noexcept {
    double sum = 0;
    double height = 1;
    double all = 0;
    double length = 1 / m_settings.frequency;
    smooth = 0;
    for (int i = 0; i < m_settings.harmonics; ++i) {
        const double n =
            simplex(m_seeds[kHills] + static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ULL, x, z);
        sum += height * n;
        smooth += height * n * find_kept(length, voxel);
        all += height;
        height *= m_settings.smoothness;
        length /= 2;
        x *= 2;
        z *= 2;
        if (height < 1e-4)
            break;
    }
    smooth /= all;
    return sum / all;
}

double Terrain::ridges(double x, double z, double voxel, double& smooth) const noexcept {
    constexpr double kMean = 0.51;   // of a ridge: replaces an octave that is left out
    constexpr double kCrest = 0.03;  // rounds the crests
    double sum = 0;
    double height = 1;
    double all = 0;
    double weight = 1;
    double length = kRidgeLength / m_settings.frequency;
    smooth = 0;
    for (int i = 0; i < m_settings.harmonics; ++i) {
        const double n =
            simplex(m_seeds[kRidges] + static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ULL, x, z);
        const double flank = 1 - std::sqrt(n * n + kCrest * kCrest);
        const double ridge = flank * flank;
        sum += height * weight * ridge;
        smooth += height * weight * mixed(kMean, ridge, find_kept(length, voxel));
        weight = std::min(weight * ridge * 2.2, 1.0);  // valleys stay smooth
        all += height;
        height *= m_settings.smoothness;
        length /= 2;
        x *= 2;
        z *= 2;
        if (height < 1e-4)
            break;
    }
    smooth /= all;
    return sum / all;
}

Terrain::Heights Terrain::heights(const Region& region, double x, double z,
                                  double voxel) const noexcept {
    const double f = m_settings.frequency;
    const double px = (x + m_origin_x + region.warp_x) * f;
    const double pz = (z + m_origin_z + region.warp_z) * f;
    double hill_smooth = 0;
    double ridge = 0;
    double ridge_smooth = 0;
    const double hill = hills(px, pz, voxel, hill_smooth);
    if (region.mountains > 0)
        ridge = ridges(px / kRidgeLength, pz / kRidgeLength, voxel, ridge_smooth);
    const double desert = smooth_step(0.6, 0.72, region.temperature) *
                          smooth_step(0.5, 0.38, region.moisture) * region.inland;
    const double world = m_settings.world_height;
    // Ledges and gullies of the mountains.
    double crags = 0;
    if (region.mountains > 0) {
        crags = region.mountains * std::min(0.05, 8 / world) *
                simplex(m_seeds[kCrags], px * (1 / 0.09), pz * (1 / 0.09));
        crags += region.mountains * std::min(0.022, 4 / world) *
                 simplex(m_seeds[kCrags] + 1, px * (1 / 0.04), pz * (1 / 0.04));
    }
    const auto height = [&](double hill_part, double ridge_part, double crag_part) {
        double e = region.land + region.hills * (hill_part + 0.25 * region.inland);
        // Table mountains: hot, dry, with steep sides.
        e += desert *
             (0.16 * smooth_step(0.16, 0.24, hill_part) + 0.12 * smooth_step(0.42, 0.5, hill_part));
        e += region.mountains * (0.02 + 1.05 * ridge_part * (0.5 + 0.5 * ridge_part)) + crag_part;
        if (const double river = std::abs(region.river); river < 1) {
            // A river lies at sea level, so it does not cut into mountains.
            constexpr double kBanks = 0.14;
            const double depth = std::min(0.03, 5 / world) * (1 - river / kBanks);
            const double carved =
                river < kBanks ? -depth - 0.004 : mixed(-0.004, e, smooth_step(kBanks, 1, river));
            e = mixed(e, std::min(e, carved), 1 - smooth_step(0.02, 0.3, region.mountains));
        }
        return m_settings.water_level + world * e;
    };
    Heights out;
    out.full = out.smooth = height(hill, ridge, crags);
    if (voxel > 1)
        out.smooth = height(hill_smooth, ridge_smooth, crags * find_kept(0.09 / f, voxel));
    const auto bounded = [&](double v) { return std::clamp(v, lowest() + 1, highest() - 1); };
    out.full = bounded(out.full);
    out.smooth = bounded(out.smooth);
    return out;
}

namespace {

constexpr double kFrame = 256;  // half of what a camera frames

// Calls visit with the middles of 16 x 16 parts of the frame.
template <class Visit>
void over_frame(double half, const Visit& visit) {
    constexpr int kParts = 16;
    for (int i = 0; i < kParts * kParts; ++i)
        visit((i % kParts + 0.5) * (2 * half / kParts) - half,
              (i / kParts + 0.5) * (2 * half / kParts) - half);
}

}  // namespace

double Terrain::highest_about_origin(double half) const noexcept {
    double highest = m_settings.water_level;
    over_frame(half, [&](double x, double z) {
        highest = std::max(highest, heights(region(x, z), x, z, 1).full);
    });
    return highest;
}

// Scenic score of a place: some water, mountains, woods and meadows, snow; high ground behind.
double Terrain::beauty() const noexcept {
    constexpr double kPlaces = 256;
    double water = 0;
    double high = 0;
    double low = 0;
    double wood = 0;
    double cold = 0;
    double behind = 0;
    double desert = 0;
    over_frame(kFrame, [&](double x, double z) {
        const Region r = region(x, z);
        const double e =
            (heights(r, x, z, 1).full - m_settings.water_level) / m_settings.world_height;
        water += e < 0;
        high += e > 0.4;
        low += e > 0 && e < 0.15;
        wood += e > 0.02 && e < 0.4 && r.moisture > 0.5;
        cold += r.temperature - 0.5 * e < 0.22;
        desert += r.temperature > 0.66 && r.moisture < 0.45;
        if (e > 0.3)
            behind += (x - z) / kFrame;  // a camera frames the world from the south-west
    });
    const auto near = [](double share, double wanted) {
        return 1 - std::min(std::abs(share / kPlaces - wanted) / wanted, 1.0);
    };
    return 1.2 * near(water, 0.25) + 1.2 * near(high, 0.16) + 0.8 * near(low, 0.3) +
           near(wood, 0.3) + 0.6 * near(cold, 0.1) + 0.2 * near(desert, 0.1) +
           0.6 * std::clamp(behind / kPlaces * 5, -1.0, 1.0);
}

void Terrain::find_origin() {
    constexpr int kTries = 96;
    constexpr double kStep = 64;  // whole boxes
    double best = -1e9;
    double x = 0;
    double z = 0;
    for (int i = 0; i < kTries; ++i) {
        const std::uint64_t h = place_hash(m_seeds[kPlace], i, 0);
        m_origin_x = kStep * static_cast<double>(static_cast<std::int64_t>(h & 0xFFFF) - 0x8000);
        m_origin_z =
            kStep * static_cast<double>(static_cast<std::int64_t>(h >> 16 & 0xFFFF) - 0x8000);
        const double found = beauty();
        if (found > best) {
            best = found;
            x = m_origin_x;
            z = m_origin_z;
        }
    }
    m_origin_x = x;
    m_origin_z = z;
}

}  // namespace terravox::procedural
