#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "voxelserver/data/sunlight/scene.hpp"
#include "voxelserver/data/sunlight/sun.hpp"

namespace terravox::sunlight::test {

/// The light that a photograph is taken in.
struct Weather {
    float sky = 0.2F;  ///< light in the shadow over that in the sun
    float veil = 0;
    float clouds = 0;  ///< how much of the sun clouds take away, in places
    float lost = 0;    ///< share of the light that the air between takes away
};

/// Flat ground in fields of different brightness, with houses of flat roofs on it.
class MadeTown {
public:
    static constexpr int kSide = 192;
    static constexpr int kMargin = 40;

    explicit MadeTown(std::uint32_t seed) : m_state(seed * 2654435761U + 12345U) {
        for (int i = 0; i < 60; ++i) {
            const double turn = 1.5 * random();
            m_houses.push_back({random() * kSide, random() * kSide, 3 + 5 * random(),
                                3 + 5 * random(), 4 + 8 * random(), 0.1 + 0.3 * random(),
                                std::cos(turn), std::sin(turn)});
        }
        for (double& field : m_fields)
            field = 0.1 + 0.25 * random();
        for (int z = 0; z < kSide * kFine; ++z)
            for (int x = 0; x < kSide * kFine; ++x)
                m_heights.push_back(
                    static_cast<float>(tallest((x + 0.5) / kFine, (z + 0.5) / kFine)));
    }

    /// What a photograph without light would show.
    [[nodiscard]] float albedo(int x, int z) const {
        double height = 0;
        const House* top = nullptr;
        for (const House& house : m_houses)
            if (house.holds(x + 0.5, z + 0.5) && house.height_m > height) {
                height = house.height_m;
                top = &house;
            }
        const auto field = static_cast<std::size_t>((z / 24) * 8 + x / 24);
        return static_cast<float>(top != nullptr ? top->albedo : m_fields[field]);
    }

    [[nodiscard]] double height_m(double x, double z) const {
        const auto column = static_cast<int>(std::floor(x * kFine));
        const auto row = static_cast<int>(std::floor(z * kFine));
        if (column < 0 || row < 0 || column >= kSide * kFine || row >= kSide * kFine)
            return 0;
        return m_heights[static_cast<std::size_t>(row) * kSide * kFine +
                         static_cast<std::size_t>(column)];
    }

    /// The share of a cell's 3 x 3 samples that the sun reaches, by fine steps towards it: another
    /// way than that of the code under test.
    [[nodiscard]] float sunlit(int x, int z, const Sun& sun) const {
        constexpr double kDegree = std::numbers::pi / 180;
        const double east = std::sin(sun.azimuth_deg * kDegree);
        const double south = -std::cos(sun.azimuth_deg * kDegree);
        const double rise = std::tan(sun.altitude_deg * kDegree);
        int lit = 0;
        for (int sample = 0; sample < 9; ++sample) {
            const double px = x + (sample % 3 + 0.5) / 3;
            const double pz = z + (sample / 3 + 0.5) / 3;
            const double own = height_m(px, pz);
            bool seen = true;
            for (double run = 0.25; seen && run * rise < 13 - own; run += 0.25)
                seen = height_m(px + run * east, pz + run * south) <= own + run * rise;
            lit += seen ? 1 : 0;
        }
        return static_cast<float>(lit) / 9;
    }

    [[nodiscard]] Scene photographed(const Sun& sun, const Weather& weather) const {
        Scene scene(kSide, kSide, kMargin, 1);
        std::uint32_t noise = 7;
        for (int z = 0; z < kSide; ++z)
            for (int x = 0; x < kSide; ++x) {
                const std::size_t i = scene.index(x, z);
                const double height = height_m(x + 0.5, z + 0.5);
                scene.top_m[i] = static_cast<float>(height);
                scene.kind[i] = height > 0 ? Kind::kRoof : Kind::kGround;
                noise = noise * 1664525U + 1013904223U;
                const float grain = 0.97F + 0.06F * static_cast<float>(noise >> 8) / 16777216.0F;
                const float cloud =
                    weather.clouds *
                    static_cast<float>(0.5 + 0.5 * std::sin(x * 0.05) * std::cos(z * 0.07));
                const float sunlight = sunlit(x, z, sun) * (1 - cloud);
                const float light = weather.sky + (1 - weather.sky) * sunlight;
                const float value =
                    (1 - weather.lost) * albedo(x, z) * grain * light + weather.veil;
                scene.photo[i] = {value, value, value};
                scene.shown[i] = 1;
            }
        return scene;
    }

private:
    struct House {
        double x;
        double z;
        double half_x;
        double half_z;
        double height_m;
        double albedo;
        double cosine;  ///< of its turn
        double sine;
        [[nodiscard]] bool holds(double px, double pz) const {
            const double along = (px - x) * cosine + (pz - z) * sine;
            const double across = (pz - z) * cosine - (px - x) * sine;
            return std::abs(along) < half_x && std::abs(across) < half_z;
        }
    };
    static constexpr int kFine = 6;  ///< heights along a cell
    [[nodiscard]] double tallest(double x, double z) const {
        double out = 0;
        for (const House& house : m_houses)
            if (house.holds(x, z))
                out = std::max(out, house.height_m);
        return out;
    }
    double random() {
        m_state = m_state * 1664525U + 1013904223U;
        return static_cast<double>(m_state >> 8) / 16777216.0;
    }
    std::uint32_t m_state;
    std::vector<House> m_houses;
    std::vector<float> m_heights;
    std::array<double, 64> m_fields{};
};

}  // namespace terravox::sunlight::test
