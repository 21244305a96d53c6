#include "voxelserver/make/worlds/heightmap/heightmap_columns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace terravox::heightmap {

HeightFile& HeightGrid::open_file(Open& open, std::size_t i) const {
    constexpr std::size_t kMaxOpen = 16;
    const auto found =
        std::find_if(open.begin(), open.end(), [&](const auto& f) { return f.first == i; });
    if (found != open.end())
        std::rotate(found, found + 1, open.end());
    else {
        if (open.size() >= kMaxOpen)
            open.erase(open.begin());
        open.emplace_back(i, std::make_unique<HeightFile>(m_files[i].reading));
    }
    return *open.back().second;
}

/// The contributions of the rasters so far to a rectangle of columns.
struct HeightGrid::Sum {
    std::int32_t x;
    std::int32_t z;
    int width;
    int height;
    double side;                         ///< of a column, units of the CRS
    std::vector<double> metres, weight;  ///< weighted sum; weights up to 1
    std::vector<std::uint8_t> known;     ///< 1: the cell under the column's middle has a height
    [[nodiscard]] std::size_t index(int i, int j) const noexcept {
        return static_cast<std::size_t>(j) * static_cast<std::size_t>(width) +
               static_cast<std::size_t>(i);
    }
    [[nodiscard]] double easting(double i) const noexcept { return (x + i) * side; }
    [[nodiscard]] double northing(double j) const noexcept { return -(z + j) * side; }
    void add(std::size_t at, double value_m, double share, bool is_known) noexcept {
        const double left = std::min(share, 1 - weight[at]);
        if (left > 0) {
            metres[at] += left * value_m;
            weight[at] += left;
        }
        if (is_known)
            known[at] = 1;
    }
};

namespace {

/// A range of cells [first, first + count), cut to [0, size).
struct Range {
    int first = 0;
    int count = 0;
};
Range cut(double a, double b, int size) noexcept {
    const double low = std::clamp(std::floor(std::min(a, b)), 0.0, static_cast<double>(size));
    const double high = std::clamp(std::ceil(std::max(a, b)), 0.0, static_cast<double>(size));
    return {static_cast<int>(low), static_cast<int>(high - low)};
}

}  // namespace

HeightGrid::HeightGrid(std::vector<File> files, grid::Frame frame, int threads)
    : m_files(std::move(files)),
      m_frame(std::move(frame)),
      m_idle(static_cast<std::size_t>(std::max(threads, 1))) {}

ColumnHeights HeightGrid::read(int level, std::int32_t x, std::int32_t z, int width, int height) {
    const double scale = static_cast<double>(std::int64_t{1} << level);
    const double side = m_frame.units_per_voxel() * scale;
    const auto count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
    Sum sum{x,
            z,
            width,
            height,
            side,
            std::vector<double>(count),
            std::vector<double>(count),
            std::vector<std::uint8_t>(count)};
    const auto lease = m_idle.borrow([] { return std::make_unique<Open>(); });
    constexpr double kAll = 1 - 1e-9;
    for (std::size_t i = 0; i < m_files.size(); ++i) {
        if (i > 0 &&
            std::all_of(sum.weight.begin(), sum.weight.end(), [](double w) { return w >= kAll; }))
            break;
        const HeightFile::Outline& o = m_files[i].outline;
        if (sum.easting(width) <= o.west || sum.easting(0) >= o.east ||
            sum.northing(0) <= o.south || sum.northing(height) >= o.north)
            continue;
        HeightFile& file = open_file(*lease, i);
        const HeightFile::Grid grid = file.grid_for(side);
        if (std::max(std::abs(grid.dx), std::abs(grid.dy)) * (1 + 1e-9) >= side)
            add_between(file, grid, sum);
        else
            add_means(file, grid, side, sum);
    }
    ColumnHeights out{x, z, width, height,
                      std::vector<double>(count, std::numeric_limits<double>::quiet_NaN())};
    const double per_metre = m_frame.y(1) / scale;
    for (std::size_t i = 0; i < count; ++i)
        if (sum.known[i] != 0 && sum.weight[i] > 0)
            out.voxels[i] = sum.metres[i] / sum.weight[i] * per_metre;
    return out;
}

// Bilinear between the middles of four cells. A missing cell adds nothing; a column has a height
// where the cell under its middle has one.
void HeightGrid::add_between(HeightFile& file, const HeightFile::Grid& grid, Sum& sum) const {
    const auto cell_x = [&](double i) { return (sum.easting(i) - grid.x0) / grid.dx; };
    const auto cell_y = [&](double j) { return (sum.northing(j) - grid.y0) / grid.dy; };
    const auto widened = [](double a, double b, int size) {
        return cut(std::min(a, b) - 1, std::max(a, b) + 1, size);
    };
    const Range across = widened(cell_x(0), cell_x(sum.width), grid.width);
    const Range down = widened(cell_y(0), cell_y(sum.height), grid.height);
    if (across.count <= 0 || down.count <= 0)
        return;
    const Cells cells = file.read(grid, across.first, down.first, across.count, down.count);
    const auto value = [&](int cx, int cy) {
        const bool inside = cx >= across.first && cx < across.first + across.count &&
                            cy >= down.first && cy < down.first + down.count;
        return inside ? cells.at(cx, cy) : std::numeric_limits<double>::quiet_NaN();
    };
    for (int j = 0; j < sum.height; ++j)
        for (int i = 0; i < sum.width; ++i) {
            const double px = cell_x(i + 0.5);
            const double py = cell_y(j + 0.5);
            if (!(px > -1 && px < grid.width + 1.0 && py > -1 && py < grid.height + 1.0))
                continue;
            const double u = px - 0.5;
            const double v = py - 0.5;
            const double floor_u = std::floor(u);
            const double floor_v = std::floor(v);
            const double fu = u - floor_u;
            const double fv = v - floor_v;
            const int x0 = static_cast<int>(floor_u);
            const int y0 = static_cast<int>(floor_v);
            double total = 0;
            double weight = 0;
            for (int k = 0; k < 4; ++k) {
                const double w = ((k & 1) != 0 ? fu : 1 - fu) * ((k & 2) != 0 ? fv : 1 - fv);
                const double h = value(x0 + (k & 1), y0 + (k >> 1));
                if (w > 0 && !std::isnan(h)) {
                    total += w * h;
                    weight += w;
                }
            }
            if (weight <= 0)
                continue;
            sum.add(sum.index(i, j), total / weight, weight,
                    !std::isnan(
                        value(static_cast<int>(std::floor(px)), static_cast<int>(std::floor(py)))));
        }
}

// The mean of the cells in the column, each weighted by its area inside. A column of which less
// than half has heights has none.
void HeightGrid::add_means(HeightFile& file, const HeightFile::Grid& grid, double side,
                           Sum& sum) const {
    const auto cell_x = [&](double i) { return (sum.easting(i) - grid.x0) / grid.dx; };
    const auto cell_y = [&](double j) { return (sum.northing(j) - grid.y0) / grid.dy; };
    const Range across = cut(cell_x(0), cell_x(sum.width), grid.width);
    const Range down = cut(cell_y(0), cell_y(sum.height), grid.height);
    if (across.count <= 0 || down.count <= 0)
        return;
    const Cells cells = file.read(grid, across.first, down.first, across.count, down.count);
    const double whole = side / std::abs(grid.dx) * (side / std::abs(grid.dy));
    for (int j = 0; j < sum.height; ++j) {
        const double y_a = std::min(cell_y(j), cell_y(j + 1));
        const double y_b = std::max(cell_y(j), cell_y(j + 1));
        const Range rows = cut(y_a, y_b, grid.height);
        for (int i = 0; i < sum.width; ++i) {
            const double x_a = std::min(cell_x(i), cell_x(i + 1));
            const double x_b = std::max(cell_x(i), cell_x(i + 1));
            const Range columns = cut(x_a, x_b, grid.width);
            double total = 0;
            double weight = 0;
            for (int cy = rows.first; cy < rows.first + rows.count; ++cy) {
                const double tall =
                    std::min(y_b, cy + 1.0) - std::max(y_a, static_cast<double>(cy));
                for (int cx = columns.first; cx < columns.first + columns.count; ++cx) {
                    const double h = cells.at(cx, cy);
                    const double area =
                        tall * (std::min(x_b, cx + 1.0) - std::max(x_a, static_cast<double>(cx)));
                    if (area > 0 && !std::isnan(h)) {
                        total += area * h;
                        weight += area;
                    }
                }
            }
            if (weight <= 0)
                continue;
            const std::size_t at = sum.index(i, j);
            sum.add(at, total / weight, weight / whole, false);
            if (sum.weight[at] >= 0.5 - 1e-9)
                sum.known[at] = 1;
        }
    }
}

using voxel::Material;
using voxel::VoxelAttr;

namespace {

// Slope from a middle and its neighbours on one axis, some of which may be missing.
double measure_slope(double before, double here, double after) noexcept {
    if (!std::isnan(before) && !std::isnan(after))
        return (after - before) / 2;
    if (!std::isnan(after))
        return after - here;
    return std::isnan(before) ? 0 : here - before;
}

}  // namespace

HeightmapColumns::HeightmapColumns(int level, const ColumnHeights& heights,
                                   const imagery::Raster& colours)
    : m_tops(kSide * kSide, kNothing),
      m_appearances(static_cast<std::size_t>(voxel::kBoxSizeX) * voxel::kBoxSizeZ) {
    // The voxel that holds the height is solid, so columns of level 0 end half a voxel above it on
    // average; coarser ones end where those do, rounded. A mean of equal numbers may be one bit too
    // small: heights that miss a voxel by less than a millionth are counted as in it.
    constexpr double kNudge = 1e-6;
    const double up = std::ldexp(0.5, -level) + 0.5 + kNudge;
    for (int z = -1; z <= voxel::kBoxSizeZ; ++z)
        for (int x = -1; x <= voxel::kBoxSizeX; ++x) {
            const auto height = [&](int dx, int dz) {
                return heights.at(heights.x + x + 1 + dx, heights.z + z + 1 + dz);
            };
            const double here = height(0, 0);
            if (std::isnan(here))
                continue;
            const auto top = static_cast<std::int32_t>(std::floor(here + up));
            m_tops[static_cast<std::size_t>((z + 1) * kSide + x + 1)] = top;
            m_highest = std::max(m_highest, top);
            m_lowest = std::min(m_lowest, top);
            if (x < 0 || z < 0 || x >= voxel::kBoxSizeX || z >= voxel::kBoxSizeZ)
                continue;
            const auto at = static_cast<std::size_t>(z * voxel::kBoxSizeX + x);
            const double dx = measure_slope(height(-1, 0), here, height(1, 0));
            const double dz = measure_slope(height(0, -1), here, height(0, 1));
            m_appearances[at] = appearance(std::sqrt(dx * dx + dz * dz), colours, at);
        }
}

VoxelAttr HeightmapColumns::appearance(double slope, const imagery::Raster& colours,
                                       std::size_t at) noexcept {
    constexpr double kBare = 0.75,
                     kRock = 1.1;  // 37 and 48 degrees: soil slides, then nothing holds
    VoxelAttr out;
    out.material = slope > kRock   ? Material::kRock
                   : slope > kBare ? Material::kGround
                                   : Material::kGrass;
    if (colours.empty() || (colours.flags[at] & imagery::Raster::kColour) == 0)
        return out;
    out.colour = colours.colour[at];
    out.flags = VoxelAttr::kHasColour;
    // A green colour means grass; any other may be anything.
    const voxel::Rgb8 c = out.colour;
    if (out.material == Material::kGrass && !(c.g >= c.r && c.g > c.b))
        out.material = Material::kGround;
    return out;
}

VoxelAttr HeightmapColumns::attr(int x, int z, std::int32_t depth) const noexcept {
    // Voxels of soil below grass; in the photo's colour, because a photo shows the slope as soil.
    constexpr std::int32_t kTurf = 3;
    VoxelAttr out = m_appearances[static_cast<std::size_t>(z * voxel::kBoxSizeX + x)];
    if (depth == 0)
        return out;
    if (depth > kTurf || out.material == Material::kRock) {
        if (depth > kTurf) {
            out.flags = 0;
            out.colour = {};
        }
        out.material = Material::kRock;
    } else if (out.material == Material::kGrass) {
        out.material = out.has_colour() ? Material::kGround : Material::kSoil;
    }
    return out;
}

}  // namespace terravox::heightmap
