#include "raytracer/analyse/objects/label_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace terravox::analyse {
namespace {

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
    output::GdalOptions options = {
        {"COMPRESS", "DEFLATE"}, {"ZLEVEL", "1"}, {"SPARSE_OK", "TRUE"}, {"BIGTIFF", "YES"}};
    m_dataset.reset(GDALCreate(GDALGetDriverByName("GTiff"),
                               m_file.temporary_path().string().c_str(), columns, rows, 1,
                               GDT_Int32, options.list()));
    watch.check(m_dataset != nullptr);
}

void LabelFile::read(int row, Numbers& numbers) const {
    const output::GdalWatch watch(m_attempt);
    numbers.resize(static_cast<std::size_t>(m_columns));
    watch.check(GDALRasterIO(GDALGetRasterBand(m_dataset.get(), 1), GF_Read, 0, row, m_columns, 1,
                             numbers.data(), m_columns, 1, GDT_Int32, 0, 0) == CE_None);
}

void LabelFile::write(int row, Numbers& numbers) const {
    const output::GdalWatch watch(m_attempt);
    watch.check(GDALRasterIO(GDALGetRasterBand(m_dataset.get(), 1), GF_Write, 0, row, m_columns, 1,
                             numbers.data(), m_columns, 1, GDT_Int32, 0, 0) == CE_None);
}

LabelFile::LabelFile(const std::filesystem::path& out, ConnectedCells& found, int columns, int rows)
    : LabelFile(out, columns, rows) {
    found.each_row([&](int row, Numbers& numbers) { write(row, numbers); });
}

LabelFile::LabelFile(const std::filesystem::path& out, const std::vector<ObjectPolygon>& polygons,
                     int columns, int rows, int near, const std::stop_token& stop)
    : LabelFile(out, columns, rows) {
    Numbers numbers;
    for (const ObjectPolygon& polygon : polygons)
        for (const overlay::Footprint& part : polygon.parts) {
            check_stop(stop);
            const int first = static_cast<int>(
                std::clamp(std::floor(part.min()[1]), 0.0, static_cast<double>(rows)));
            const int end = static_cast<int>(
                std::clamp(std::ceil(part.max()[1]), 0.0, static_cast<double>(rows)));
            const int west = static_cast<int>(
                std::clamp(std::floor(part.min()[0]), 0.0, static_cast<double>(columns)));
            const int east = static_cast<int>(
                std::clamp(std::ceil(part.max()[0]), 0.0, static_cast<double>(columns)));
            for (int row = first; row < end; ++row) {
                const std::vector<double> crossings = part.crossings(row + 0.5);
                read(row, numbers);
                for (int x = west; x < east; ++x) {
                    std::int32_t& number = numbers[static_cast<std::size_t>(x)];
                    if (number == 0 && overlay::Footprint::is_inside(crossings, x + 0.5))
                        number = static_cast<std::int32_t>(polygon.feature) + 1;
                }
                write(row, numbers);
            }
        }
    widen(near, stop);
}

void LabelFile::widen(int near, const std::stop_token& stop) const {
    // Rows as they were before: those around the one that is written.
    std::array<Numbers, kMaxWindow> around;
    const auto before = [&](int row) -> Numbers& {
        return around[static_cast<std::size_t>(row % kMaxWindow)];
    };
    for (int row = 0; row < std::min(near, m_rows); ++row)
        read(row, before(row));
    const std::vector<Neighbour> nearest_first = neighbours(near);
    Numbers wider;
    for (int row = 0; row < m_rows; ++row) {
        check_stop(stop);
        if (row + near < m_rows)
            read(row + near, before(row + near));
        wider = before(row);
        for (int x = 0; x < m_columns; ++x) {
            std::int32_t& number = wider[static_cast<std::size_t>(x)];
            for (const Neighbour& to : nearest_first) {
                if (number != 0)
                    break;
                const int column = x + to.column;
                const int other = row + to.row;
                if (column >= 0 && column < m_columns && other >= 0 && other < m_rows)
                    number = before(other)[static_cast<std::size_t>(column)];
            }
        }
        write(row, wider);
    }
}

}  // namespace terravox::analyse
