#include "raytracer/analyse/objects/cell_labels.hpp"

#include <algorithm>
#include <array>

#include "common/util/error.hpp"

namespace terravox::analyse {

void check_stop(const std::stop_token& stop) {
    if (stop.stop_requested())
        throw util::Error("interrupted");
}

RowLabels::RowLabels(int columns)
    : m_parents(1, kNone), m_row(static_cast<std::size_t>(columns), kNone) {}

std::int32_t RowLabels::joined(std::int32_t label) noexcept {
    while (m_parents[static_cast<std::size_t>(label)] != label) {
        auto& parent = m_parents[static_cast<std::size_t>(label)];
        // The way is halved for those that follow.
        parent = m_parents[static_cast<std::size_t>(parent)];
        label = parent;
    }
    return label;
}

std::int32_t RowLabels::new_label() {
    if (last() == kMaxLabels)
        throw util::Error("find the buildings: more than " + std::to_string(kMaxLabels) +
                          " pieces of them; allowed: fewer, by a smaller --area or a coarser "
                          "--resolution");
    const std::int32_t label = last() + 1;
    m_parents.push_back(label);
    return label;
}

ConnectedCells::ConnectedCells(CellFile& cells, double cell_m2, const std::stop_token& stop)
    : m_cells(cells), m_stop(stop) {
    RowLabels labels(cells.columns());
    EnergyRows rows(cells, {0, 0, cells.columns(), cells.rows()});
    const auto join = [&](std::int32_t kept, std::int32_t dropped) {
        // A label of this row has no sums yet.
        const auto from = m_growing.find(dropped);
        if (from == m_growing.end())
            return;
        m_growing[kept].sums.add(from->second.sums);
        m_growing.erase(from);
    };
    while (rows.next()) {
        check_stop(stop);
        labels.next([&](int x) { return rows.is_building(x); }, join);
        for (int x = 0; x < cells.columns(); ++x) {
            const std::int32_t label = labels.row()[static_cast<std::size_t>(x)];
            if (label == RowLabels::kNone)
                continue;
            Growing& growing = m_growing[labels.joined(label)];
            growing.sums.add(rows.at(x), cell_m2);
            growing.last_row = rows.row();
        }
        finish_above(rows.row(), cell_m2);
    }
    finish_above(cells.rows(), cell_m2);
    m_numbers.resize(static_cast<std::size_t>(labels.last()) + 1);
    number_all();
    for (std::size_t label = 1; label < m_numbers.size(); ++label) {
        const auto joined =
            static_cast<std::size_t>(labels.joined(static_cast<std::int32_t>(label)));
        m_numbers[label] = m_numbers[joined];
    }
}

void ConnectedCells::finish_above(int row, double cell_m2) {
    for (auto at = m_growing.begin(); at != m_growing.end();) {
        if (at->second.last_row == row) {
            ++at;
            continue;
        }
        if (m_done.size() == kMaxObjects)
            throw util::Error("find the buildings: more than " + std::to_string(kMaxObjects) +
                              "; allowed: fewer, by a smaller --area");
        m_done.emplace(at->first, collect_facts(at->second.sums, cell_m2));
        at = m_growing.erase(at);
    }
}

void ConnectedCells::number_all() {
    m_facts.reserve(m_done.size());
    for (const auto& [label, facts] : m_done) {
        m_facts.push_back(facts);
        m_numbers[static_cast<std::size_t>(label)] = static_cast<std::int32_t>(m_facts.size());
    }
    m_done.clear();
}

namespace {

/// Wide enough for a building, and so low that two rows of blocks of the widest raster are a part
/// of GDAL's cache: rows are read and written one after the other, too.
constexpr int kBlockColumns = 256;
constexpr int kBlockRows = 64;
constexpr int kMaxWindow = 2 * LabelFile::kMaxNear + 1;

/// A neighbour of a cell.
struct Neighbour {
    int column = 0;
    int row = 0;
};

/// The neighbours of a cell, the nearest ones first; of those as near, by row and column.
std::vector<Neighbour> neighbours(int near) {
    std::vector<Neighbour> out;
    for (int row = -near; row <= near; ++row)
        for (int column = -near; column <= near; ++column)
            if (column * column + row * row <= near * near)
                out.push_back({column, row});
    std::stable_sort(out.begin(), out.end(), [](const Neighbour& a, const Neighbour& b) {
        return a.column * a.column + a.row * a.row < b.column * b.column + b.row * b.row;
    });
    return out;
}

}  // namespace

LabelFile::LabelFile(const std::filesystem::path& out, int columns, int rows)
    : m_attempt("number the objects for " + out.string()),
      m_columns(columns),
      m_rows(rows),
      m_file(std::filesystem::path(out).replace_extension(".labels.tif")) {
    const output::GdalWatch watch(m_attempt);
    m_dataset = output::create_tiff(m_file.temporary_path(),
                                    {columns, rows, 1, GDT_Int32, kBlockColumns, kBlockRows},
                                    {{"ZLEVEL", "1"}, {"SPARSE_OK", "TRUE"}}, watch);
}

void LabelFile::read(const CellRectangle& area, Numbers& numbers) const {
    const output::GdalWatch watch(m_attempt);
    numbers.resize(static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height));
    watch.check(GDALRasterIO(GDALGetRasterBand(m_dataset.get(), 1), GF_Read, area.x0, area.y0,
                             area.width, area.height, numbers.data(), area.width, area.height,
                             GDT_Int32, 0, 0) == CE_None);
}

void LabelFile::write(const CellRectangle& area, Numbers& numbers) const {
    const output::GdalWatch watch(m_attempt);
    watch.check(GDALRasterIO(GDALGetRasterBand(m_dataset.get(), 1), GF_Write, area.x0, area.y0,
                             area.width, area.height, numbers.data(), area.width, area.height,
                             GDT_Int32, 0, 0) == CE_None);
}

LabelFile::LabelFile(const std::filesystem::path& out, ConnectedCells& found, int columns, int rows)
    : LabelFile(out, columns, rows) {
    found.each_row([&](int at, Numbers& numbers) { write(row(at), numbers); });
}

LabelFile::LabelFile(const std::filesystem::path& out, const std::vector<ObjectPolygon>& polygons,
                     int columns, int rows, int near, const std::stop_token& stop)
    : LabelFile(out, columns, rows) {
    for (const ObjectPolygon& polygon : polygons)
        for (const overlay::Footprint& part : polygon.parts)
            number(part, static_cast<std::int32_t>(polygon.feature) + 1, stop);
    widen(near, stop);
}

void LabelFile::number(const overlay::Footprint& part, std::int32_t number,
                       const std::stop_token& stop) const {
    CellRectangle area = cells_around(part, m_columns, m_rows);
    if (area.width <= 0)
        return;
    const int end = area.y0 + area.height;
    // A polygon may be as large as the raster, which may be larger than memory.
    const int strip_rows = std::max(1, kStripCells / area.width);
    Numbers numbers;
    for (; area.y0 < end; area.y0 += area.height) {
        area.height = std::min(strip_rows, end - area.y0);
        read(area, numbers);
        auto cell = numbers.begin();
        for (int y = area.y0; y < area.y0 + area.height; ++y) {
            check_stop(stop);
            const std::vector<double> crossings = part.crossings(y + 0.5);
            for (int x = area.x0; x < area.x0 + area.width; ++x, ++cell)
                if (*cell == 0 && overlay::Footprint::is_inside(crossings, x + 0.5))
                    *cell = number;
        }
        write(area, numbers);
    }
}

void LabelFile::widen(int near, const std::stop_token& stop) const {
    // Rows as they were before: those around the one that is written.
    std::array<Numbers, kMaxWindow> around;
    const auto before = [&](int y) -> Numbers& {
        return around[static_cast<std::size_t>(y % kMaxWindow)];
    };
    for (int y = 0; y < std::min(near, m_rows); ++y)
        read(row(y), before(y));
    const std::vector<Neighbour> nearest_first = neighbours(near);
    Numbers wider;
    for (int y = 0; y < m_rows; ++y) {
        check_stop(stop);
        if (y + near < m_rows)
            read(row(y + near), before(y + near));
        wider = before(y);
        for (int x = 0; x < m_columns; ++x) {
            std::int32_t& number = wider[static_cast<std::size_t>(x)];
            for (const Neighbour& to : nearest_first) {
                if (number != 0)
                    break;
                const int column = x + to.column;
                const int other = y + to.row;
                if (column >= 0 && column < m_columns && other >= 0 && other < m_rows)
                    number = before(other)[static_cast<std::size_t>(column)];
            }
        }
        write(row(y), wider);
    }
}

}  // namespace terravox::analyse
