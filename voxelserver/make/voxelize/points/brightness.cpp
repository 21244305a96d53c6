#include "voxelserver/make/voxelize/points/brightness.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace terravox::voxelize {
namespace {

constexpr double kComparedCell_m = 64;
constexpr std::size_t kMinEchoes = 64;
constexpr std::size_t kMinInCell = 3;  ///< of one line, for its median to count
/// A quotient of the 95th and the 5th percentile below this is no difference of materials.
constexpr double kMinContrast = 1.3;
/// More numbers are not those of flight lines.
constexpr std::size_t kMaxLines = 256;
/// Enough for a chain of some twenty lines, of which only neighbours overlap.
constexpr int kRounds = 400;

struct Sorted {
    std::int64_t cell_x;
    std::int64_t cell_z;
    std::size_t line;  ///< index
    std::uint16_t intensity;
    friend auto operator<=>(const Sorted&, const Sorted&) = default;
};

/// How much brighter one line sees the same ground than another, over all cells that both see.
struct Comparison {
    double weight = 0;
    double ratio_sum = 0;  ///< of weight * own median / other's median
};

double percentile(std::vector<double>& values, double share) {
    const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + at, values.end());
    return values[static_cast<std::size_t>(at)];
}

class Lines {
public:
    explicit Lines(std::vector<std::uint16_t> numbers)
        : m_numbers(std::move(numbers)),
          m_compared(m_numbers.size() * m_numbers.size()),
          m_gain(m_numbers.size(), 1.0) {}

    [[nodiscard]] std::size_t count() const noexcept { return m_numbers.size(); }
    [[nodiscard]] std::uint16_t number(std::size_t i) const noexcept { return m_numbers[i]; }
    [[nodiscard]] std::size_t compute_index(std::uint16_t number) const noexcept {
        return static_cast<std::size_t>(
            std::lower_bound(m_numbers.begin(), m_numbers.end(), number) - m_numbers.begin());
    }
    [[nodiscard]] double gain(std::size_t i) const noexcept { return m_gain[i]; }

    void compare(std::size_t a, double median_a, std::size_t b, double median_b, double weight) {
        add(a, b, weight, median_a / median_b);
        add(b, a, weight, median_b / median_a);
    }

    // Gauss-Seidel: each line's gain is the mean of what its neighbours say.
    void settle() {
        for (int round = 0; round < kRounds; ++round)
            for (std::size_t a = 0; a < count(); ++a) {
                double weight = 0;
                double sum = 0;
                for (std::size_t b = 0; b < count(); ++b) {
                    const Comparison& c = at(a, b);
                    weight += c.weight;
                    sum += c.ratio_sum * m_gain[b];
                }
                if (weight > 0)
                    m_gain[a] = sum / weight;
            }
    }

    /// The lines that are compared with each other, directly or through others.
    [[nodiscard]] std::vector<std::vector<std::size_t>> groups() const {
        std::vector<std::vector<std::size_t>> out;
        std::vector<char> seen(count(), 0);
        for (std::size_t first = 0; first < count(); ++first) {
            if (seen[first] != 0)
                continue;
            std::vector<std::size_t> group{first};
            seen[first] = 1;
            for (std::size_t i = 0; i < group.size(); ++i)
                for (std::size_t b = 0; b < count(); ++b)
                    if (seen[b] == 0 && at(group[i], b).weight > 0) {
                        seen[b] = 1;
                        group.push_back(b);
                    }
            out.push_back(std::move(group));
        }
        return out;
    }

private:
    [[nodiscard]] const Comparison& at(std::size_t a, std::size_t b) const noexcept {
        return m_compared[a * count() + b];
    }
    void add(std::size_t a, std::size_t b, double weight, double ratio) {
        Comparison& c = m_compared[a * count() + b];
        c.weight += weight;
        c.ratio_sum += weight * ratio;
    }

    std::vector<std::uint16_t> m_numbers;  ///< sorted
    std::vector<Comparison> m_compared;
    std::vector<double> m_gain;
};

std::vector<std::uint16_t> list_numbers(const std::vector<GroundEcho>& echoes) {
    std::vector<std::uint16_t> out;
    for (const GroundEcho& e : echoes)
        out.push_back(e.line);
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

struct CellMedian {
    std::size_t line;
    double median;
    double count;
};

// Compares the lines of each cell. `echoes` are sorted: by cell, then by line, then by intensity.
void compare_cells(const std::vector<Sorted>& echoes, Lines& lines) {
    std::vector<CellMedian> cell;
    for (std::size_t begin = 0; begin < echoes.size();) {
        const auto same_line = [&](const Sorted& e) {
            return e.cell_x == echoes[begin].cell_x && e.cell_z == echoes[begin].cell_z &&
                   e.line == echoes[begin].line;
        };
        std::size_t end = begin;
        while (end < echoes.size() && same_line(echoes[end]))
            ++end;
        const std::size_t count = end - begin;
        if (count >= kMinInCell)
            cell.push_back({echoes[begin].line,
                            static_cast<double>(echoes[begin + count / 2].intensity),
                            static_cast<double>(count)});
        const bool cell_ends = end == echoes.size() || echoes[end].cell_x != echoes[begin].cell_x ||
                               echoes[end].cell_z != echoes[begin].cell_z;
        begin = end;
        if (!cell_ends)
            continue;
        for (std::size_t a = 0; a < cell.size(); ++a)
            for (std::size_t b = a + 1; b < cell.size(); ++b)
                lines.compare(cell[a].line, cell[a].median, cell[b].line, cell[b].median,
                              std::min(cell[a].count, cell[b].count));
        cell.clear();
    }
}

bool within(const grid::ColumnRect& a, const grid::ColumnRect& b, double voxels) noexcept {
    return a.min_x - voxels < b.max_x && b.min_x - voxels < a.max_x && a.min_z - voxels < b.max_z &&
           b.min_z - voxels < a.max_z;
}

}  // namespace

std::uint8_t BrightnessScale::brightness(std::uint16_t intensity,
                                         std::uint16_t line) const noexcept {
    const auto found =
        std::lower_bound(m_lines.begin(), m_lines.end(), line,
                         [](const Line& l, std::uint16_t number) { return l.number < number; });
    if (intensity == 0 || found == m_lines.end() || found->number != line)
        return kUnknown;
    const double value = kBrightGround * intensity / found->bright_ground + 0.5;
    return static_cast<std::uint8_t>(std::clamp(value, 1.0, 255.0));
}

BrightnessScale scale_from(std::vector<GroundEcho> echoes, double voxel_m) {
    if (echoes.size() < kMinEchoes)
        return {};
    std::vector<std::uint16_t> numbers = list_numbers(echoes);
    if (numbers.size() > kMaxLines)
        return {};
    Lines lines(std::move(numbers));
    const double cell = kComparedCell_m / voxel_m;
    std::vector<Sorted> sorted;
    sorted.reserve(echoes.size());
    for (const GroundEcho& e : echoes)
        sorted.push_back({static_cast<std::int64_t>(std::floor(e.x / cell)),
                          static_cast<std::int64_t>(std::floor(e.z / cell)),
                          lines.compute_index(e.line), e.intensity});
    std::sort(sorted.begin(), sorted.end());
    compare_cells(sorted, lines);
    lines.settle();
    constexpr double kBright = 0.8;
    constexpr double kLow = 0.05;
    std::vector<BrightnessScale::Line> found;
    bool contrast = false;
    for (const auto& group : lines.groups()) {
        std::vector<double> values;
        for (const Sorted& e : sorted)
            if (std::find(group.begin(), group.end(), e.line) != group.end())
                values.push_back(e.intensity / lines.gain(e.line));
        const double bright = percentile(values, kBright);
        contrast =
            contrast || percentile(values, 1 - kLow) > kMinContrast * percentile(values, kLow);
        for (const std::size_t line : group)
            found.push_back({lines.number(line), bright * lines.gain(line)});
    }
    if (!contrast)
        return {};
    std::sort(found.begin(), found.end(),
              [](const auto& a, const auto& b) { return a.number < b.number; });
    return BrightnessScale(std::move(found));
}

std::vector<std::size_t> files_sharing_scale(std::size_t file,
                                             std::span<const grid::ColumnRect> bounds,
                                             double voxel_m) {
    std::vector<std::size_t> out;
    for (std::size_t k = 0; k < bounds.size(); ++k)
        if (within(bounds[file], bounds[k], kSharedScale_m / voxel_m))
            out.push_back(k);
    return out;
}

}  // namespace terravox::voxelize
