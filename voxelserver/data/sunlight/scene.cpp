#include "voxelserver/data/sunlight/scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace terravox::sunlight {
namespace {

constexpr float kUnknownHeight = std::numeric_limits<float>::quiet_NaN();

bool is_known(float height) noexcept {
    return height == height;
}

/// Heights and kinds around a cell that are known.
struct Neighbours {
    float sum = 0;
    float lowest = std::numeric_limits<float>::infinity();
    float count = 0;
    Kind kind = Kind::kUnknown;
};

/// A cell and the eight around it, row by row.
template <class Visit>
void each_neighbour(const Surface& surface, std::size_t i, const Visit& visit) {
    const int x = static_cast<int>(i % static_cast<std::size_t>(surface.width));
    const int z = static_cast<int>(i / static_cast<std::size_t>(surface.width));
    for (int nz = std::max(z - 1, 0); nz <= std::min(z + 1, surface.height - 1); ++nz)
        for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, surface.width - 1); ++nx)
            visit(surface.index(nx, nz));
}

Neighbours find_neighbours(const Surface& surface, std::size_t i) {
    Neighbours out;
    each_neighbour(surface, i, [&](std::size_t j) {
        if (!is_known(surface.top_m[j]))
            return;
        out.sum += surface.top_m[j];
        out.lowest = std::min(out.lowest, surface.top_m[j]);
        ++out.count;
        out.kind = std::max(out.kind, surface.kind[j]);
    });
    return out;
}

}  // namespace

Surface::Surface(int given_width, int given_height, int given_margin, double given_cell_m)
    : width(given_width), height(given_height), margin(given_margin), cell_m(given_cell_m) {
    const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    top_m.assign(count, kUnknownHeight);
    kind.assign(count, Kind::kUnknown);
}

Scene::Scene(int given_width, int given_height, int given_margin, double given_cell_m)
    : Scene(Surface(given_width, given_height, given_margin, given_cell_m)) {}

Scene::Scene(Surface surface) : Surface(std::move(surface)) {
    photo.resize(size());
    shown.assign(size(), 0);
}

void fill_gaps(Surface& surface, int reach) {
    struct Filled {
        std::size_t index;
        float top_m;
        Kind kind;
    };
    // Unknown cells next to known ones: those that are filled in the next round.
    std::vector<std::size_t> front;
    std::vector<std::uint8_t> was_in_front(surface.size(), 0);
    const auto add_to_front = [&](std::size_t i) {
        if (is_known(surface.top_m[i]) || was_in_front[i] != 0)
            return;
        was_in_front[i] = 1;
        front.push_back(i);
    };
    for (std::size_t i = 0; i < surface.size(); ++i)
        if (!is_known(surface.top_m[i]) && find_neighbours(surface, i).count > 0)
            add_to_front(i);
    std::vector<Filled> filled;
    for (int round = 0; round < reach && !front.empty(); ++round) {
        filled.clear();
        for (const std::size_t i : front) {
            const Neighbours near = find_neighbours(surface, i);
            // Wide gaps are water, or what lies behind a roof.
            const bool small = round < kSmallGap;
            filled.push_back({i, small ? near.sum / near.count : near.lowest,
                              small ? near.kind : Kind::kUnknown});
        }
        front.clear();
        for (const Filled& f : filled) {
            surface.top_m[f.index] = f.top_m;
            surface.kind[f.index] = f.kind;
            each_neighbour(surface, f.index, add_to_front);
        }
    }
    // Nothing casts a shadow from there, and nothing is said about it.
    constexpr float kLowest_m = -1e4F;
    for (float& top : surface.top_m)
        if (!is_known(top))
            top = kLowest_m;
}

Surface inner_cells(const Surface& surface, int margin) {
    const int cut = surface.margin - margin;
    Surface out(surface.width - 2 * cut, surface.height - 2 * cut, margin, surface.cell_m);
    for (int z = 0; z < out.height; ++z) {
        const auto from = static_cast<std::ptrdiff_t>(surface.index(cut, z + cut));
        const auto to = static_cast<std::ptrdiff_t>(out.index(0, z));
        std::copy_n(surface.top_m.begin() + from, out.width, out.top_m.begin() + to);
        std::copy_n(surface.kind.begin() + from, out.width, out.kind.begin() + to);
    }
    return out;
}

namespace {

Cover common_cover(Cover a, Cover b) noexcept {
    if (a == b || b == Cover::kUnknown)
        return a;
    return a == Cover::kUnknown ? b : Cover::kOther;
}

}  // namespace

Scene halved(const Scene& scene) {
    Scene out(scene.width / 2, scene.height / 2, scene.margin / 2, 2 * scene.cell_m);
    if (!scene.cover.empty())
        out.cover.assign(out.size(), Cover::kUnknown);
    for (int z = 0; z < out.height; ++z)
        for (int x = 0; x < out.width; ++x) {
            const std::size_t to = out.index(x, z);
            Light sum{};
            int shown = 0;
            out.top_m[to] = -std::numeric_limits<float>::infinity();
            for (int part = 0; part < 4; ++part) {
                const std::size_t from = scene.index(2 * x + (part & 1), 2 * z + (part >> 1));
                if (scene.top_m[from] > out.top_m[to]) {
                    out.top_m[to] = scene.top_m[from];
                    out.kind[to] = scene.kind[from];
                }
                if (!scene.cover.empty())
                    out.cover[to] = common_cover(out.cover[to], scene.cover[from]);
                if (scene.shown[from] == 0)
                    continue;
                ++shown;
                for (std::size_t c = 0; c < 3; ++c)
                    sum[c] += scene.photo[from][c];
            }
            if (shown == 0)
                continue;
            out.shown[to] = 1;
            for (std::size_t c = 0; c < 3; ++c)
                out.photo[to][c] = sum[c] / static_cast<float>(shown);
        }
    return out;
}

std::vector<Slope> measure_slopes(const Surface& surface) {
    const int border = std::max(surface.margin, 1);
    // Steeper than this between two cells is an edge, not a slope.
    constexpr float kEdge = 2.5F;
    std::vector<Slope> out(surface.size());
    const auto run = static_cast<float>(surface.cell_m);
    const auto along = [&](std::size_t before, std::size_t at, std::size_t after) {
        const float rise_in = (surface.top_m[at] - surface.top_m[before]) / run;
        const float rise_out = (surface.top_m[after] - surface.top_m[at]) / run;
        const bool in = surface.kind[before] == surface.kind[at] && std::abs(rise_in) < kEdge;
        const bool on = surface.kind[after] == surface.kind[at] && std::abs(rise_out) < kEdge;
        if (in && on)
            return (rise_in + rise_out) / 2;
        if (in)
            return rise_in;
        return on ? rise_out : 0.0F;
    };
    const int first = std::max(border - 1, 1);
    for (int z = first; z < surface.height - first; ++z)
        for (int x = first; x < surface.width - first; ++x) {
            const std::size_t i = surface.index(x, z);
            out[i].east = along(i - 1, i, i + 1);
            out[i].south = along(surface.index(x, z - 1), i, surface.index(x, z + 1));
        }
    // The mean of three by three of one kind: points of a survey scatter by decimetres.
    std::vector<Slope> smooth(surface.size());
    for (int z = border; z < surface.height - border; ++z)
        for (int x = border; x < surface.width - border; ++x) {
            const std::size_t i = surface.index(x, z);
            float count = 0;
            for (int dz = -1; dz <= 1; ++dz)
                for (int dx = -1; dx <= 1; ++dx) {
                    const std::size_t j = surface.index(x + dx, z + dz);
                    if (surface.kind[j] != surface.kind[i])
                        continue;
                    smooth[i].east += out[j].east;
                    smooth[i].south += out[j].south;
                    ++count;
                }
            smooth[i].east /= count;
            smooth[i].south /= count;
        }
    return smooth;
}

}  // namespace terravox::sunlight
