#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <random>
#include <set>
#include <tuple>
#include <vector>

#include "voxelserver/data/water/body_levels.hpp"
#include "voxelserver/data/water/water_cells.hpp"

namespace terravox::water::test {

inline WaterCell nothing_seen() {
    WaterCell c;
    c.covered = true;
    return c;
}
inline WaterCell ground_at(float height, std::uint16_t points = 20) {
    WaterCell c = nothing_seen();
    c.ground = height;
    c.ground_points = points;
    return c;
}
inline WaterCell water_at(float height, std::uint16_t points = 3) {
    WaterCell c = nothing_seen();
    c.water = height;
    c.water_points = points;
    return c;
}
inline WaterCell thing() {
    WaterCell c = nothing_seen();
    c.other_points = 20;
    return c;
}
inline WaterCell wet(WaterCell c) {
    c.looks_wet = true;
    return c;
}

/// Cells from a function of the place; records which patches were requested.
class FunctionSource final : public CellSource {
public:
    using Make = std::function<WaterCell(std::int32_t x, std::int32_t z)>;
    FunctionSource(int side, Make make) : m_side(side), m_make(std::move(make)) {}

    std::shared_ptr<const CellPatch> cells(std::int32_t px, std::int32_t pz) override {
        const std::lock_guard lock(m_mutex);
        m_requested.insert({px, pz});
        auto& patch = m_patches[{px, pz}];
        if (!patch) {
            auto made = std::make_shared<CellPatch>();
            made->side = m_side;
            for (int z = 0; z < m_side; ++z)
                for (int x = 0; x < m_side; ++x)
                    made->cells.push_back(m_make(px * m_side + x, pz * m_side + z));
            patch = made;
        }
        return patch;
    }
    [[nodiscard]] std::set<std::pair<std::int32_t, std::int32_t>> requested() const {
        const std::lock_guard lock(m_mutex);
        return m_requested;
    }

private:
    int m_side;
    Make m_make;
    mutable std::mutex m_mutex;
    std::map<std::pair<std::int32_t, std::int32_t>, std::shared_ptr<const CellPatch>> m_patches;
    std::set<std::pair<std::int32_t, std::int32_t>> m_requested;
};

/// A rectangle of cells with water of known height, drawn with a round brush; and what a scanner
/// sees of it. Heights in metres.
class Landscape {
public:
    struct Place {
        double x;
        double z;
    };

    Landscape(int width, int height, std::uint32_t seed)
        : m_width(width),
          m_height(height),
          m_truth(count(), kNoLevel),
          m_near(count(), 1e9),
          m_random(seed) {}

    [[nodiscard]] int width() const noexcept { return m_width; }
    [[nodiscard]] int height() const noexcept { return m_height; }
    [[nodiscard]] bool inside(std::int32_t x, std::int32_t z) const noexcept {
        return x >= 0 && z >= 0 && x < m_width && z < m_height;
    }
    [[nodiscard]] float truth(std::int32_t x, std::int32_t z) const {
        return inside(x, z) ? m_truth[index(x, z)] : kNoLevel;
    }

    /// A course along points a fraction of a cell apart, `radius` cells to each side; falls from
    /// `top` by `slope` for each cell of way.
    /// @return the cells of its middle, in the order of the flow
    std::vector<std::pair<int, int>> river(const std::vector<Place>& points, double radius,
                                           double top, double slope) {
        std::vector<std::pair<int, int>> middle;
        double way = 0;
        for (std::size_t i = 0; i < points.size(); ++i) {
            if (i > 0)
                way += std::hypot(points[i].x - points[i - 1].x, points[i].z - points[i - 1].z);
            brush(points[i], radius, top - way * slope);
            const std::pair<int, int> cell{static_cast<int>(std::floor(points[i].x)),
                                           static_cast<int>(std::floor(points[i].z))};
            if (inside(cell.first, cell.second) && (middle.empty() || middle.back() != cell))
                middle.push_back(cell);
        }
        return middle;
    }
    /// A lake: one level, whatever was there.
    void lake(Place centre, double radius, double level) {
        each(centre, radius, [&](std::size_t i, double) {
            m_truth[i] = static_cast<float>(level);
            m_near[i] = 0;
        });
    }
    void island(Place centre, double radius) {
        each(centre, radius, [&](std::size_t i, double) { m_truth[i] = kNoLevel; });
    }

    /// What is seen: returns in one of four water cells, 1 to 6 of them, noise of `noise_m` each;
    /// `strays` of those cells lie 0.2 to 0.6 m high.
    [[nodiscard]] std::vector<WaterCell> scan(double noise_m = 0.04, double strays = 0.03) {
        std::vector<WaterCell> out(m_truth.size());
        for (std::size_t i = 0; i < out.size(); ++i) {
            if (std::isnan(m_truth[i])) {
                out[i] = ground_at(30);
                continue;
            }
            out[i] = nothing_seen();
            if (uniform() >= 0.25)
                continue;
            const int points = 1 + static_cast<int>(uniform() * 6);
            double level = static_cast<double>(m_truth[i]) + noise_m * normal() / std::sqrt(points);
            if (uniform() < strays)
                level += 0.2 + 0.4 * uniform();
            out[i] = water_at(static_cast<float>(level), static_cast<std::uint16_t>(points));
        }
        return out;
    }

    [[nodiscard]] double uniform() { return static_cast<double>(m_random()) / 4294967296.0; }
    [[nodiscard]] double normal() {
        double sum = -6;
        for (int i = 0; i < 12; ++i)
            sum += uniform();
        return sum;
    }
    [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t z) const {
        return static_cast<std::size_t>(z) * static_cast<std::size_t>(m_width) +
               static_cast<std::size_t>(x);
    }

private:
    [[nodiscard]] std::size_t count() const {
        return static_cast<std::size_t>(m_width) * static_cast<std::size_t>(m_height);
    }
    template <class Visit>
    void each(Place centre, double radius, const Visit& visit) const {
        const auto x0 = static_cast<int>(std::floor(centre.x - radius));
        const auto z0 = static_cast<int>(std::floor(centre.z - radius));
        for (int z = z0; z <= centre.z + radius; ++z)
            for (int x = x0; x <= centre.x + radius; ++x) {
                const double d = std::hypot(x + 0.5 - centre.x, z + 0.5 - centre.z);
                if (inside(x, z) && d <= radius)
                    visit(index(x, z), d);
            }
    }
    void brush(Place centre, double radius, double level) {
        each(centre, radius, [&](std::size_t i, double d) {
            if (d < m_near[i]) {
                m_near[i] = d;
                m_truth[i] = static_cast<float>(level);
            }
        });
    }

    int m_width;
    int m_height;
    std::vector<float> m_truth;
    std::vector<double> m_near;
    std::mt19937 m_random;
};

/// Points along a wave: x from x0 to x1, z around z0.
inline std::vector<Landscape::Place> wave(double x0, double x1, double z0, double amplitude,
                                          double length) {
    std::vector<Landscape::Place> out;
    const double step = x1 > x0 ? 0.1 : -0.1;
    for (int i = 0; i * step * (x1 > x0 ? 1 : -1) <= std::abs(x1 - x0); ++i)
        out.push_back(
            {x0 + i * step, z0 + amplitude * std::sin(6.283185307179586 * i * step / length)});
    return out;
}
/// The water of a landscape as one body, with what was seen of it.
/// @param hidden cells of which nothing was seen, by their place
template <class Hidden>
Body make_body(const Landscape& land, const std::vector<WaterCell>& seen, const Hidden& hidden) {
    Body out;
    for (int z = 0; z < land.height(); ++z)
        for (int x = 0; x < land.width(); ++x) {
            if (std::isnan(land.truth(x, z)))
                continue;
            const WaterCell& c = seen[land.index(x, z)];
            out.places.push_back({x, z});
            out.samples.push_back(c.water_points > 0 && !hidden(x, z)
                                      ? LevelSample{c.water, c.water_points}
                                      : LevelSample{});
        }
    return out;
}

inline std::vector<Landscape::Place> line(Landscape::Place a, Landscape::Place b) {
    std::vector<Landscape::Place> out;
    const int steps = static_cast<int>(std::hypot(b.x - a.x, b.z - a.z) * 8) + 1;
    for (int i = 0; i <= steps; ++i)
        out.push_back({a.x + (b.x - a.x) * i / steps, a.z + (b.z - a.z) * i / steps});
    return out;
}

}  // namespace terravox::water::test
