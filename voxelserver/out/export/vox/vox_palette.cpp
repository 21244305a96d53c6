#include "voxelserver/out/export/vox/vox_palette.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "common/util/det_math.hpp"
#include "common/voxel/colour.hpp"

namespace terravox::exports {

void ColourCounts::add(voxel::Rgb8 c) {
    Sum& sum = m_sums[to_key(c)];
    ++sum.count;
    sum.r += c.r;
    sum.g += c.g;
    sum.b += c.b;
    while (m_sums.size() > kMaxCells)
        coarsen();
}

void ColourCounts::coarsen() {
    ++m_shift;
    std::unordered_map<std::uint32_t, Sum> next;
    for (const auto& [key, sum] : m_sums) {
        Sum& to = next[key >> 1 & 0x7F7F7F];
        to.count += sum.count;
        to.r += sum.r;
        to.g += sum.g;
        to.b += sum.b;
    }
    m_sums = std::move(next);
}

std::vector<ColourCounts::Cell> ColourCounts::cells() const {
    std::vector<Cell> out;
    out.reserve(m_sums.size());
    for (const auto& [key, sum] : m_sums) {
        const auto mean = [&](std::uint64_t s) {
            return static_cast<std::uint8_t>((s + sum.count / 2) / sum.count);
        };
        out.push_back({key, sum.count, {mean(sum.r), mean(sum.g), mean(sum.b)}});
    }
    std::sort(out.begin(), out.end(), [](const Cell& a, const Cell& b) { return a.key < b.key; });
    return out;
}

namespace {

using Lab = std::array<double, 3>;
// Rounds of k-means; the sum of squares falls by less than a hundredth in the last.
constexpr int kRounds = 12;

double cube_root(double x) noexcept {
    return x > 0 ? det::pow(x, 1.0 / 3) : 0;
}

Lab to_cielab(voxel::Rgb8 c) noexcept {
    const double r = voxel::srgb_to_linear(c.r);
    const double g = voxel::srgb_to_linear(c.g);
    const double b = voxel::srgb_to_linear(c.b);
    const double l = cube_root(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
    const double m = cube_root(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
    const double s = cube_root(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
    return {0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s,
            1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s,
            0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s};
}

std::uint8_t srgb_8(double linear) noexcept {
    const double c = linear <= 0.0031308 ? 12.92 * std::max(linear, 0.0)
                                         : 1.055 * det::pow(std::min(linear, 1.0), 1 / 2.4) - 0.055;
    return static_cast<std::uint8_t>(c * 255 + 0.5);
}

voxel::Rgb8 to_rgb(const Lab& lab) noexcept {
    const auto cube = [](double v) { return v * v * v; };
    const double l = cube(lab[0] + 0.3963377774 * lab[1] + 0.2158037573 * lab[2]);
    const double m = cube(lab[0] - 0.1055613458 * lab[1] - 0.0638541728 * lab[2]);
    const double s = cube(lab[0] - 0.0894841775 * lab[1] - 1.2914855480 * lab[2]);
    return {srgb_8(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
            srgb_8(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
            srgb_8(-0.0041960863 * l - 0.7034186147 * m + 1.7076147010 * s)};
}

double distance2(const Lab& a, const Lab& b) noexcept {
    const double x = a[0] - b[0];
    const double y = a[1] - b[1];
    const double z = a[2] - b[2];
    return x * x + y * y + z * z;
}

struct Points {
    std::vector<Lab> labs;
    std::vector<double> weights;
};

/// A group of points of the median cut, [begin, end) of the order; `spread` is their sum of squares
/// along `axis`, the widest.
struct Group {
    std::size_t begin = 0;
    std::size_t end = 0;
    std::size_t axis = 0;
    double spread = 0;
    Lab mean{};
};

Group choose_group(const Points& points, std::span<const std::uint32_t> order, std::size_t begin,
                   std::size_t end) {
    Group out{begin, end, 0, 0, {}};
    double weight = 0;
    Lab sum{};
    Lab squares{};
    for (std::size_t i = begin; i < end; ++i) {
        const double w = points.weights[order[i]];
        weight += w;
        for (std::size_t a = 0; a < 3; ++a)
            sum[a] += w * points.labs[order[i]][a];
    }
    for (std::size_t a = 0; a < 3; ++a)
        out.mean[a] = sum[a] / weight;
    for (std::size_t i = begin; i < end; ++i)
        for (std::size_t a = 0; a < 3; ++a) {
            const double d = points.labs[order[i]][a] - out.mean[a];
            squares[a] += points.weights[order[i]] * d * d;
        }
    out.axis = static_cast<std::size_t>(std::max_element(squares.begin(), squares.end()) -
                                        squares.begin());
    out.spread = end - begin > 1 ? squares[out.axis] : 0;
    return out;
}

std::vector<Lab> median_cut(const Points& points, std::size_t max_colours) {
    std::vector<std::uint32_t> order(points.labs.size());
    std::iota(order.begin(), order.end(), 0u);
    std::vector<Group> groups = {choose_group(points, order, 0, order.size())};
    while (groups.size() < max_colours) {
        const auto widest =
            std::max_element(groups.begin(), groups.end(),
                             [](const Group& a, const Group& b) { return a.spread < b.spread; });
        if (widest->spread <= 0)
            break;
        const Group g = *widest;
        const auto first = order.begin() + static_cast<std::ptrdiff_t>(g.begin);
        const auto last = order.begin() + static_cast<std::ptrdiff_t>(g.end);
        std::stable_sort(first, last, [&](std::uint32_t a, std::uint32_t b) {
            return points.labs[a][g.axis] < points.labs[b][g.axis];
        });
        auto cut = std::partition_point(
            first, last, [&](std::uint32_t i) { return points.labs[i][g.axis] < g.mean[g.axis]; });
        cut = std::clamp(cut, first + 1, last - 1);
        const auto middle = static_cast<std::size_t>(cut - order.begin());
        *widest = choose_group(points, order, g.begin, middle);
        groups.push_back(choose_group(points, order, middle, g.end));
    }
    std::vector<Lab> out;
    for (const Group& g : groups)
        out.push_back(g.mean);
    return out;
}

std::uint8_t nearest(const Lab& to, const std::vector<Lab>& of) noexcept {
    std::size_t best = 0;
    double nearest = distance2(to, of[0]);
    for (std::size_t k = 1; k < of.size(); ++k)
        if (const double d = distance2(to, of[k]); d < nearest) {
            nearest = d;
            best = k;
        }
    return static_cast<std::uint8_t>(best);
}

}  // namespace

FewColours few_colours(std::span<const ColourCounts::Cell> cells, std::size_t max_colours) {
    FewColours out;
    out.of_cell.resize(cells.size());
    if (cells.size() <= max_colours) {
        for (std::size_t i = 0; i < cells.size(); ++i) {
            out.colours.push_back(cells[i].mean);
            out.of_cell[i] = static_cast<std::uint8_t>(i);
        }
        return out;
    }
    Points points;
    for (const auto& cell : cells) {
        points.labs.push_back(to_cielab(cell.mean));
        points.weights.push_back(static_cast<double>(cell.count));
    }
    std::vector<Lab> means = median_cut(points, max_colours);
    for (int round = 0;; ++round) {
        for (std::size_t i = 0; i < cells.size(); ++i)
            out.of_cell[i] = nearest(points.labs[i], means);
        if (round == kRounds)
            break;
        std::vector<Lab> sums(means.size());
        std::vector<double> weights(means.size());
        for (std::size_t i = 0; i < cells.size(); ++i) {
            const std::size_t k = out.of_cell[i];
            weights[k] += points.weights[i];
            for (std::size_t a = 0; a < 3; ++a)
                sums[k][a] += points.weights[i] * points.labs[i][a];
        }
        for (std::size_t k = 0; k < means.size(); ++k)
            for (std::size_t a = 0; a < 3 && weights[k] > 0; ++a)
                means[k][a] = sums[k][a] / weights[k];
    }
    for (const Lab& mean : means)
        out.colours.push_back(to_rgb(mean));
    return out;
}

using voxel::Material;

void VoxPalette::count(Material material, voxel::Rgb8 colour, bool own) {
    if (own)
        m_groups[choose_group(material)].counts.add(colour);
    else
        m_plain[voxel::material_index(material)] = true;
}

void VoxPalette::take(Group& group, Material material, std::size_t max_colours,
                      std::vector<VoxColour>& out) const {
    const auto cells = group.counts.cells();
    const FewColours few = few_colours(cells, max_colours);
    for (std::size_t i = 0; i < cells.size(); ++i)
        group.index_of_cell.emplace(cells[i].key,
                                    static_cast<std::uint8_t>(out.size() + few.of_cell[i] + 1));
    for (const voxel::Rgb8 colour : few.colours)
        out.push_back({colour, material});
}

std::vector<VoxColour> VoxPalette::choose() {
    std::vector<VoxColour> out;
    for (std::size_t m = 0; m < m_plain.size(); ++m) {
        if (!m_plain[m])
            continue;
        const auto material = static_cast<Material>(m);
        out.push_back({m_palette.of(material).colour, choose_group(material)});
        m_index_of_plain[m] = static_cast<std::uint8_t>(out.size());
    }
    // Special materials first: the others get what is left, at least 144.
    for (auto& [material, group] : m_groups)
        if (special_in_vox(material))
            take(group, material, kMaxOfSpecial, out);
    if (const auto rest = m_groups.find(Material::kAir); rest != m_groups.end())
        take(rest->second, Material::kAir, kMax - out.size(), out);
    return out;
}

std::uint8_t VoxPalette::compute_index(Material material, voxel::Rgb8 colour, bool own) const {
    if (!own)
        return m_index_of_plain[voxel::material_index(material)];
    const Group& group = m_groups.at(choose_group(material));
    return group.index_of_cell.at(group.counts.to_key(colour));
}

}  // namespace terravox::exports
