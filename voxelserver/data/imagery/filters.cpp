#include "voxelserver/data/imagery/filters.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>

#include "common/util/error.hpp"
#include "common/voxel/fingerprint.hpp"
#include "voxelserver/data/imagery/palette_file.hpp"

namespace terravox::imagery {

using voxel::Material;

namespace {

constexpr int kMaxRadius = 6;  ///< voxels

/// For each row: how far beyond a patch its result is needed by the rows that read its output.
std::vector<int> measure_reaches(const Filters& filters, const std::vector<int>& radii) {
    std::vector<int> reach(filters.size(), 0);
    for (std::size_t i = filters.size(); i-- > 0;) {
        const MaterialSet writes =
            filters[i].of | (filters[i].to ? to_bit(*filters[i].to) : filters[i].by);
        for (std::size_t j = i + 1; j < filters.size(); ++j) {
            const MaterialSet reads =
                filters[j].of | filters[j].by | (filters[j].to ? to_bit(*filters[j].to) : 0);
            if ((writes & reads) != 0)
                reach[i] = std::max(reach[i], reach[j] + radii[j]);
        }
    }
    return reach;
}

int longest_chain(const Filters& filters, const std::vector<int>& radii) {
    const auto reach = measure_reaches(filters, radii);
    int most = 0;
    for (std::size_t i = 0; i < filters.size(); ++i)
        most = std::max(most, reach[i] + radii[i]);
    return most;
}

FilterRow read_row(const PaletteFile& file, const toml::table& row, std::size_t number) {
    std::string where = "[[filter]] row " + std::to_string(number) + " ";
    file.allow_only(row, where, {"name", "of", "by", "to", "radius_m", "at_least", "at_most"});
    FilterRow out;
    out.name = row["name"].value_or(std::string());
    if (out.name.empty())
        file.fail(where + "name is missing; allowed: a text");
    where = "[[filter]] '" + out.name + "' ";
    out.of = file.materials(row, where, "of");
    out.by = file.materials(row, where, "by");
    const bool isolated = row.contains("at_most");
    if (out.of == 0 || (out.by == 0 && !isolated))
        file.fail(where + (out.of == 0 ? "of" : "by") +
                  " is missing or empty; allowed: a list of materials of materials.toml");
    if (isolated && (row.contains("by") || row.contains("at_least")))
        file.fail(where + "at_most goes without by and at_least: only the own material is counted");
    const auto to = row["to"].value_or(std::string());
    if (to != "majority" || isolated)
        out.to = file.material(where + "to", to);
    for (const char* field : {"radius_m", isolated ? "at_most" : "at_least"})
        if (!row.contains(field))
            file.fail(where + field + " is missing");
    out.radius_m = file.number(row, where, "radius_m", 0.1, 20, 1);
    out.at_least_permille =
        static_cast<int>(std::lround(1000 * file.number(row, where, "at_least", 0.001, 1, 0.5)));
    if (isolated)
        out.at_most_permille =
            static_cast<int>(std::lround(1000 * file.number(row, where, "at_most", 0, 1, 0)));
    return out;
}

/// Half widths of a disc's rows: the columns whose centres lie within radius + 1/2.
std::array<int, kMaxRadius + 1> make_disc(int radius) {
    std::array<int, kMaxRadius + 1> half{};
    for (int dz = 0; dz <= radius; ++dz) {
        int& h = half[static_cast<std::size_t>(dz)];
        while ((h + 1) * (h + 1) + dz * dz <= radius * radius + radius)
            ++h;
    }
    return half;
}

/// One store for each column: a set of bits would wait for the column before.
MaterialSet materials_in(const std::vector<Material>& columns) {
    std::array<bool, voxel::kMaterialCount> found{};
    for (const Material m : columns)
        found[static_cast<std::size_t>(m)] = true;
    MaterialSet out = 0;
    for (std::size_t m = 0; m < found.size(); ++m)
        if (found[m])
            out |= to_bit(static_cast<Material>(m));
    return out;
}

/// Runs one row over the part of a grid where its result is needed. The columns in a disc are
/// counted along rows first: those in the 1, 3, 5, ... around a column, of which a disc of radius r
/// takes 2 r + 1. All for a whole row in parallel, in bytes: no disc has more columns than these
/// can count.
class RowPass {
public:
    /// @param present all materials that occur
    RowPass(const Grid& grid, const FilterRow& row, MaterialSet present, int radius, int inset)
        : m_grid(grid),
          m_row(row),
          m_present(present),
          m_radius(radius),
          m_inset(inset),
          m_width(static_cast<std::size_t>(grid.width - 2 * inset)),
          m_disc(make_disc(radius)) {}

    /// Writes the changed columns to `out`, which starts as a copy of the grid's materials.
    void run(std::vector<Material>& out) {
        find_work();
        if (!m_any_work)
            return;
        const std::size_t columns = m_width * static_cast<std::size_t>(m_grid.height - 2 * m_inset);
        m_total.assign(columns, 0);
        m_best.assign(columns, 0);
        m_own.assign(columns, 0);
        m_winner.assign(columns, Material::kAir);
        const MaterialSet voters = m_row.by | (m_row.to ? to_bit(*m_row.to) : 0);
        if (m_row.at_most_permille >= 0) {
            count_own();
            std::fill(m_winner.begin(), m_winner.end(), *m_row.to);
        } else if (m_row.to) {
            count(voters, m_total);
            count(to_bit(*m_row.to), m_best);
            std::fill(m_winner.begin(), m_winner.end(), *m_row.to);
        } else {
            for (int m = 1; m < voxel::kMaterialCount; ++m)
                if ((voters & m_present & to_bit(static_cast<Material>(m))) != 0)
                    count_votes(static_cast<Material>(m));
        }
        decide(out);
    }

private:
    using Count = std::uint8_t;
    using Counts = std::vector<Count>;
    static_assert((2 * kMaxRadius + 1) * (2 * kMaxRadius + 1) <= UINT8_MAX);

    [[nodiscard]] std::size_t at(int x, int z) const noexcept {
        return static_cast<std::size_t>(z) * static_cast<std::size_t>(m_grid.width) +
               static_cast<std::size_t>(x);
    }
    [[nodiscard]] std::size_t local(int z) const noexcept {
        return static_cast<std::size_t>(z - m_inset) * m_width;
    }
    [[nodiscard]] bool may_change(std::size_t i) const noexcept {
        return (m_row.of & to_bit(m_grid.material[i])) != 0 &&
               (m_grid.flags.empty() || (m_grid.flags[i] & Grid::kFixed) == 0);
    }

    /// Finds the rows of the grid that contain a column that may change, and the columns that vote.
    void find_work() {
        m_work.assign(static_cast<std::size_t>(m_grid.height), 0);
        for (int z = m_inset; z < m_grid.height - m_inset; ++z)
            for (int x = m_inset; x < m_grid.width - m_inset; ++x)
                if (may_change(at(x, z))) {
                    m_work[static_cast<std::size_t>(z)] = 1;
                    m_any_work = true;
                    break;
                }
        m_votes_for = m_grid.material;
        for (std::size_t i = 0; i < m_grid.flags.size(); ++i)
            m_votes_for[i] =
                (m_grid.flags[i] & Grid::kSilent) != 0 ? Material::kAir : m_votes_for[i];
    }

    /// Adds, for each column of a row with work, the number of columns of its disc that have one of
    /// `materials`.
    void count(MaterialSet materials, Counts& into) {
        if ((materials & m_present) == 0)
            return;
        find_voters(materials & m_present);
        const auto stride = static_cast<std::size_t>(m_grid.width);
        const std::size_t width = m_width;
        const auto radius = static_cast<std::size_t>(m_radius);
        const std::size_t rows = static_cast<std::size_t>(m_grid.height - 2 * m_inset) + 2 * radius;
        m_along.resize((radius + 1) * rows * width);
        for (std::size_t row = 0; row < rows; ++row) {
            const Count* here =
                &m_voters[(row + static_cast<std::size_t>(m_inset) - radius) * stride +
                          static_cast<std::size_t>(m_inset)];
            std::copy_n(here, width, &m_along[row * width]);
            for (std::size_t half = 1; half <= radius; ++half) {
                const Count* narrower = &m_along[((half - 1) * rows + row) * width];
                Count* to = &m_along[(half * rows + row) * width];
                const Count* west = here - half;
                const Count* east = here + half;
                for (std::size_t x = 0; x < width; ++x)
                    to[x] = static_cast<Count>(narrower[x] + west[x] + east[x]);
            }
        }
        for (std::size_t row = radius; row + radius < rows; ++row) {
            if (m_work[row - radius + static_cast<std::size_t>(m_inset)] == 0)
                continue;
            Count* to = &into[(row - radius) * width];
            for (int dz = -m_radius; dz <= m_radius; ++dz) {
                const auto half =
                    static_cast<std::size_t>(m_disc[static_cast<std::size_t>(std::abs(dz))]);
                const Count* from =
                    &m_along[(half * rows + row + static_cast<std::size_t>(dz)) * width];
                for (std::size_t x = 0; x < width; ++x)
                    to[x] = static_cast<Count>(to[x] + from[x]);
            }
        }
    }

    /// 1 for each of the grid's columns that votes for one of `materials`, else 0.
    void find_voters(MaterialSet materials) {
        m_voters.assign(m_votes_for.size(), 0);
        const std::span<Count> voters = m_voters;
        const std::span<const Material> votes_for = m_votes_for;
        for (; materials != 0; materials &= materials - 1) {
            const auto m = static_cast<Material>(std::countr_zero(materials));
            for (std::size_t i = 0; i < voters.size(); ++i)
                voters[i] = votes_for[i] == m ? 1 : voters[i];
        }
    }

    void count_votes(Material m) {
        m_votes.assign(m_total.size(), 0);
        count(to_bit(m), m_votes);
        for (int z = m_inset; z < m_grid.height - m_inset; ++z) {
            if (m_work[static_cast<std::size_t>(z)] == 0)
                continue;
            const std::span row(&m_grid.material[at(m_inset, z)], m_width);
            const Count* votes = &m_votes[local(z)];
            Count* total = &m_total[local(z)];
            Count* best = &m_best[local(z)];
            Count* own = &m_own[local(z)];
            Material* winner = &m_winner[local(z)];
            // Three loops: the compiler takes several columns at once in each, and not in all of
            // them together.
            for (std::size_t x = 0; x < row.size(); ++x)
                total[x] = static_cast<Count>(total[x] + votes[x]);
            for (std::size_t x = 0; x < row.size(); ++x)
                own[x] = row[x] == m ? votes[x] : own[x];
            for (std::size_t x = 0; x < row.size(); ++x) {
                winner[x] = votes[x] > best[x] ? m : winner[x];
                best[x] = std::max(best[x], votes[x]);
            }
        }
    }

    /// The votes for each column's own material; the total is the disc's area.
    void count_own() {
        int area = 0;
        for (int dz = -m_radius; dz <= m_radius; ++dz)
            area += 2 * m_disc[static_cast<std::size_t>(std::abs(dz))] + 1;
        for (int m = 1; m < voxel::kMaterialCount; ++m)
            if ((m_row.of & to_bit(static_cast<Material>(m))) != 0)
                count_votes(static_cast<Material>(m));
        std::fill(m_total.begin(), m_total.end(), static_cast<Count>(area));
    }

    [[nodiscard]] bool changes(std::size_t i) const noexcept {
        const std::int32_t best = m_best[i];
        const std::int32_t own = m_own[i];
        const std::int32_t total = m_total[i];
        if (m_row.at_most_permille >= 0)
            return own * 1000 <= m_row.at_most_permille * total;
        if (best == 0 || (!m_row.to && own == best))
            return false;
        return best * 1000 >= m_row.at_least_permille * total;
    }

    void decide(std::vector<Material>& out) const {
        for (int z = m_inset; z < m_grid.height - m_inset; ++z) {
            if (m_work[static_cast<std::size_t>(z)] == 0)
                continue;
            for (std::size_t x = 0; x < m_width; ++x) {
                const std::size_t i = local(z) + x;
                const std::size_t to = at(m_inset, z) + x;
                if (may_change(to) && changes(i))
                    out[to] = m_winner[i];
            }
        }
    }

    const Grid& m_grid;
    const FilterRow& m_row;
    MaterialSet m_present;
    int m_radius;
    int m_inset;
    std::size_t m_width;
    std::array<int, kMaxRadius + 1> m_disc;
    bool m_any_work = false;
    std::vector<std::uint8_t> m_work;
    Counts m_voters;  ///< for each of the grid's columns
    Counts m_along;   ///< voters along rows, by half width
    Counts m_votes;
    Counts m_total;
    Counts m_best;
    Counts m_own;
    std::vector<Material> m_votes_for;  ///< for each of the grid's columns; kAir: no vote
    std::vector<Material> m_winner;     ///< for each of the part's columns
};

}  // namespace

void add_values(const Filters& filters, voxel::ByteWriter& out) {
    out.add(filters.size());
    for (const FilterRow& f : filters) {
        out.add(f.of);
        out.add(f.by);
        out.add(f.to ? static_cast<int>(*f.to) : -1);
        out.add(f.radius_m);
        out.add(f.at_least_permille);
        out.add(f.at_most_permille);
    }
}

Filters load_filters(const std::string& id_or_path) {
    constexpr std::size_t kMaxRows = kMaxMargin;  // each reads at least one voxel beyond its column
    Filters out;
    for (const PaletteFile& file : read_palette(id_or_path)) {
        const auto rows = file.rows("filter");
        if (rows.size() > kMaxRows)
            file.fail("[[filter]] has " + std::to_string(rows.size()) + " rows; allowed: up to 24");
        if (!rows.empty())
            out.clear();
        for (const toml::table* row : rows)
            out.push_back(read_row(file, *row, out.size() + 1));
    }
    return out;
}

std::vector<int> list_radii(const Filters& filters, double voxel_m) {
    std::vector<int> radii;
    for (const FilterRow& row : filters)
        radii.push_back(static_cast<int>(std::clamp(std::floor(row.radius_m / voxel_m + 0.5), 1.0,
                                                    static_cast<double>(kMaxRadius))));
    while (longest_chain(filters, radii) > kMaxMargin) {
        const auto widest = std::max_element(radii.rbegin(), radii.rend());
        if (*widest <= 1)
            throw util::Error("run the neighbourhood filters: {} rows; allowed: up to 24",
                              filters.size());
        --*widest;
    }
    return radii;
}

int measure_margin(const Filters& filters, double voxel_m) {
    return longest_chain(filters, list_radii(filters, voxel_m));
}

void apply_filters(Grid& grid, const Filters& filters, double voxel_m) {
    const auto columns = static_cast<std::size_t>(std::max(grid.width, 0)) *
                         static_cast<std::size_t>(std::max(grid.height, 0));
    const bool complete =
        grid.material.size() == columns && (grid.flags.empty() || grid.flags.size() == columns);
    if (!complete || grid.width < 2 * grid.margin || grid.height < 2 * grid.margin)
        throw util::Error(
            "run the neighbourhood filters: a grid of {} x {} with a margin of {} has {} materials",
            grid.width, grid.height, grid.margin, grid.material.size());
    const auto radii = list_radii(filters, voxel_m);
    const auto reaches = measure_reaches(filters, radii);
    if (const int margin = longest_chain(filters, radii); grid.margin < margin)
        throw util::Error(
            "run the neighbourhood filters: the grid's margin is {}; allowed: {} or more",
            grid.margin, margin);
    if (columns == 0)
        return;
    MaterialSet present = materials_in(grid.material);
    for (std::size_t i = 0; i < filters.size(); ++i) {
        // Nothing to change, or no material that could win: in most areas some materials do not
        // occur at all.
        const FilterRow& row = filters[i];
        const bool isolated = row.at_most_permille >= 0;
        const MaterialSet winners = row.to ? to_bit(*row.to) : row.by;
        if ((row.of & present) == 0 || (!isolated && (winners & present) == 0))
            continue;
        std::vector<Material> out = grid.material;
        RowPass(grid, row, present, radii[i], grid.margin - reaches[i]).run(out);
        grid.material.swap(out);
        present |= row.to ? to_bit(*row.to) : 0;
    }
}

}  // namespace terravox::imagery
