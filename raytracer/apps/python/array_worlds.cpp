#include "raytracer/apps/python/array_worlds.hpp"

#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <terravox/terravox.hpp>

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "raytracer/apps/python/calls.hpp"

namespace terravox::python {
namespace {

template <class T>
using Column = nb::ndarray<const T, nb::shape<-1>, nb::c_contig, nb::device::cpu>;
using Colours16 = nb::ndarray<const std::uint16_t, nb::shape<-1, 3>, nb::c_contig, nb::device::cpu>;
/// By layer from below, row from the north, column from the west.
using Materials = nb::ndarray<const std::uint8_t, nb::ndim<3>, nb::c_contig, nb::device::cpu>;
using Colours8 =
    nb::ndarray<const std::uint8_t, nb::shape<-1, -1, -1, 3>, nb::c_contig, nb::device::cpu>;

/// Columns of a table of points. Those that are there have a row for each point.
struct PointColumns {
    RayArray xyz;
    std::optional<Column<std::uint8_t>> classification;
    std::optional<Column<std::uint8_t>> return_number;
    std::optional<Column<std::uint8_t>> return_count;
    std::optional<Column<std::uint16_t>> intensity;
    std::optional<Colours16> rgb;
};

template <class T>
void read(const std::optional<Column<T>>& column, std::size_t row, T& value) {
    if (column)
        value = column->data()[row];
}

class ArrayPoints final : public PointSource {
public:
    /// @param columns must outlive it
    ArrayPoints(const PointColumns& columns, std::string crs)
        : m_columns(columns), m_crs(std::move(crs)) {}

    [[nodiscard]] std::string crs() const override { return m_crs; }

    bool next(std::vector<Point>& batch) override {
        constexpr std::size_t kBatch = 1 << 16;
        const std::size_t end = std::min(m_row + kBatch, m_columns.xyz.shape(0));
        if (m_row == end)
            return false;
        for (; m_row < end; ++m_row)
            batch.push_back(point(m_row));
        return true;
    }

private:
    [[nodiscard]] Point point(std::size_t row) const {
        const double* const xyz = m_columns.xyz.data() + 3 * row;
        Point out;
        out.x = xyz[0];
        out.y = xyz[1];
        out.z = xyz[2];
        read(m_columns.classification, row, out.classification);
        read(m_columns.return_number, row, out.return_number);
        read(m_columns.return_count, row, out.return_count);
        read(m_columns.intensity, row, out.intensity);
        if (m_columns.rgb)
            std::copy_n(m_columns.rgb->data() + 3 * row, 3, out.rgb.begin());
        return out;
    }

    const PointColumns& m_columns;
    std::string m_crs;
    std::size_t m_row = 0;
};

class ArrayVoxels final : public VoxelSource {
public:
    using Arrays = std::pair<Materials, std::optional<Colours8>>;

    /// @param arrays nobody changes them
    /// @param info its block has the shape of the arrays
    ArrayVoxels(std::shared_ptr<const Arrays> arrays, WorldInfo info)
        : m_materials(arrays->first.data()),
          m_colours(arrays->second ? arrays->second->data() : nullptr),
          m_arrays(std::move(arrays)),
          m_info(std::move(info)) {}

    [[nodiscard]] WorldInfo info() const override { return m_info; }

    bool fill(const std::array<std::int32_t, 3>& corner, std::span<Voxel> voxels) override {
        constexpr std::array<std::int32_t, 3> kSize{kWidth, kHeight, kWidth};
        const VoxelBlock& block = m_info.block;
        std::array<std::int32_t, 3> from{};
        std::array<std::int32_t, 3> to{};
        for (std::size_t a = 0; a < 3; ++a) {
            from[a] = std::max(corner[a], block.min[a]);
            to[a] = std::min(corner[a] + kSize[a], block.max[a]);
        }
        bool any = false;
        for (std::int32_t y = from[1]; y < to[1]; ++y)
            for (std::int32_t z = from[2]; z < to[2]; ++z)
                for (std::int32_t x = from[0]; x < to[0]; ++x) {
                    const std::size_t to_voxel =
                        index(y - corner[1], z - corner[2], x - corner[0], kWidth, kWidth);
                    const std::size_t source =
                        index(y - block.min[1], z - block.min[2], x - block.min[0],
                              block.max[2] - block.min[2], block.max[0] - block.min[0]);
                    any |= set(voxels[to_voxel], source);
                }
        return any;
    }

private:
    [[nodiscard]] static std::size_t index(std::int32_t layer, std::int32_t row,
                                           std::int32_t column, std::int32_t rows,
                                           std::int32_t columns) noexcept {
        const auto wide = [](std::int32_t v) { return static_cast<std::size_t>(v); };
        return (wide(layer) * wide(rows) + wide(row)) * wide(columns) + wide(column);
    }

    bool set(Voxel& voxel, std::size_t source) const noexcept {
        voxel.material = m_materials[source];
        if (voxel.material == 0)
            return false;
        if (m_colours != nullptr) {
            voxel.has_colour = true;
            std::copy_n(m_colours + 3 * source, 3, voxel.rgb.begin());
        }
        return true;
    }

    // Read without the interpreter's lock, which the arrays themselves would want.
    const std::uint8_t* m_materials;
    const std::uint8_t* m_colours;
    std::shared_ptr<const Arrays> m_arrays;
    WorldInfo m_info;
};

World world_of_points(PointColumns columns, std::string crs, OpenOptions options,
                      const nb::object& progress) {
    const auto shared = shared_with_threads(std::move(columns));
    return interruptible(progress, [shared, crs = std::move(crs),
                                    options = std::move(options)](const Control& control) {
        ArrayPoints points(*shared, crs);
        return World::voxelize(points, options, control);
    });
}

/// @param corner of the lowest coordinates, voxels
World world_of_voxels(Materials materials, std::optional<Colours8> colours,
                      const std::array<std::int32_t, 3>& corner, double voxel_m, std::string crs,
                      std::string title) {
    WorldInfo info;
    info.title = std::move(title);
    info.voxel_m = voxel_m;
    info.crs = std::move(crs);
    const std::array<std::size_t, 3> size{materials.shape(2), materials.shape(0),
                                          materials.shape(1)};
    info.block.min = corner;
    for (std::size_t a = 0; a < 3; ++a)
        info.block.max[a] = corner[a] + static_cast<std::int32_t>(size[a]);
    const auto arrays =
        shared_with_threads(ArrayVoxels::Arrays(std::move(materials), std::move(colours)));
    return World::of(std::make_shared<ArrayVoxels>(arrays, std::move(info)));
}

}  // namespace

void add_array_worlds(nb::module_& module) {
    using namespace nb::literals;
    module.def(
        "world_of_points",
        [](RayArray xyz, std::optional<Column<std::uint8_t>> classification,
           std::optional<Column<std::uint8_t>> return_number,
           std::optional<Column<std::uint8_t>> return_count,
           std::optional<Column<std::uint16_t>> intensity, std::optional<Colours16> rgb,
           std::string crs, std::string classes, std::optional<double> voxel_m,
           std::vector<std::string> orthophotos, std::vector<std::string> additions,
           std::vector<std::pair<std::string, std::string>> fields, const nb::object& progress) {
            OpenOptions options;
            options.classes = std::move(classes);
            options.voxel_m = voxel_m;
            options.orthophotos = std::move(orthophotos);
            options.additions = std::move(additions);
            options.fields = std::move(fields);
            return world_of_points(
                {std::move(xyz), std::move(classification), std::move(return_number),
                 std::move(return_count), std::move(intensity), std::move(rgb)},
                std::move(crs), std::move(options), progress);
        },
        "xyz"_a, "classification"_a.none(), "return_number"_a.none(), "return_count"_a.none(),
        "intensity"_a.none(), "rgb"_a.none(), "crs"_a, "classes"_a, "voxel_m"_a.none(),
        "orthophotos"_a, "additions"_a, "fields"_a, "progress"_a.none());
    module.def("world_of_voxels", &world_of_voxels, "materials"_a, "colours"_a.none(), "corner"_a,
               "voxel_m"_a, "crs"_a, "title"_a);
}

}  // namespace terravox::python
