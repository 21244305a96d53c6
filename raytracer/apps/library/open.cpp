#include <terravox/error.hpp>
#include <terravox/sources.hpp>
#include <terravox/world.hpp>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "common/geo/crs.hpp"
#include "common/util/error.hpp"
#include "common/util/folders.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "raytracer/apps/library/guarded.hpp"
#include "raytracer/apps/library/state.hpp"
#include "raytracer/core/scene/scene.hpp"
#include "voxelserver/data/lidar/las_writer.hpp"
#include "voxelserver/make/worlds/open/open_world.hpp"

namespace terravox {
namespace {

static_assert(VoxelSource::kWidth == voxel::kBoxSizeX && VoxelSource::kWidth == voxel::kBoxSizeZ &&
              VoxelSource::kHeight == voxel::kBoxSizeY);

void refuse(const std::string& what) {
    throw util::UsageError("open a world of one's own: " + what);
}

voxel::WorldInfo make_info(const WorldInfo& own) {
    constexpr std::int32_t kFarthest = 1 << 26;
    if (!(own.voxel_m > 0 && own.voxel_m <= 1000))
        refuse("voxel_m = " + std::to_string(own.voxel_m) + "; allowed: above 0, up to 1000");
    for (std::size_t a = 0; a < 3; ++a)
        if (own.block.min[a] >= own.block.max[a] || own.block.min[a] < -kFarthest ||
            own.block.max[a] > kFarthest)
            refuse("block = " + std::to_string(own.block.min[a]) + " to " +
                   std::to_string(own.block.max[a]) +
                   " along an axis; allowed: rising, -2^26 to 2^26");
    voxel::WorldInfo out;
    out.title = own.title;
    out.bounds = {own.block.min, own.block.max};
    out.voxel_m = own.voxel_m;
    out.levels = voxel::levels_for(out.bounds);
    out.licence = own.licence;
    out.attribution = own.attribution;
    if (own.crs.empty())
        return out;
    const geo::Crs crs = geo::Crs::from_text(own.crs);
    if (crs.geographic())
        refuse("crs = " + own.crs + ", in degrees; allowed: one in metres or feet");
    out.crs = crs.name();
    out.crs_wkt = crs.wkt();
    out.crs_units_per_voxel = own.voxel_m / crs.metres_per_unit();
    const double x = (out.bounds.min[0] + out.bounds.max[0]) / 2.0 * out.crs_units_per_voxel;
    const double y = -(out.bounds.min[2] + out.bounds.max[2]) / 2.0 * out.crs_units_per_voxel;
    out.centre = geo::map_place(crs, x, y);
    return out;
}

std::size_t to_number(int x, int y, int z) noexcept {
    return static_cast<std::size_t>((y * voxel::kBoxSizeZ + z) * voxel::kBoxSizeX + x);
}

voxel::Material to_material(const Voxel& own) noexcept {
    return static_cast<voxel::Material>(own.material < voxel::kMaterialCount
                                            ? own.material
                                            : static_cast<std::uint8_t>(voxel::Material::kUnknown));
}

voxel::VoxelAttr to_attr(const Voxel& own) noexcept {
    voxel::VoxelAttr out;
    out.material = to_material(own);
    out.source_class = own.source_class;
    if (own.has_colour) {
        out.flags |= voxel::VoxelAttr::kHasColour;
        out.colour = {own.rgb[0], own.rgb[1], own.rgb[2]};
    }
    return out;
}

/// Adds a column of a box, run by run: neighbours of one kind together.
void add_column(voxel::BoxBuilder& builder, std::span<const Voxel> voxels, int x, int z) {
    const auto kind = [&](int y) {
        const Voxel& at = voxels[to_number(x, y, z)];
        return at.material == 0 ? 0 : voxel::see_through(to_material(at)) ? 1 : 2;
    };
    for (int y = 0; y < voxel::kBoxSizeY;) {
        const int what = kind(y);
        int end = y + 1;
        while (end < voxel::kBoxSizeY && kind(end) == what)
            ++end;
        if (what != 0)
            builder.add(x, z, y, end, what == 2);
        y = end;
    }
}

std::shared_ptr<const voxel::Box> to_box(const voxel::BoxKey& key, std::span<const Voxel> voxels) {
    voxel::BoxBuilder builder;
    for (int z = 0; z < voxel::kBoxSizeZ; ++z)
        for (int x = 0; x < voxel::kBoxSizeX; ++x)
            add_column(builder, voxels, x, z);
    return builder.build(key,
                         [&](int x, int y, int z) { return to_attr(voxels[to_number(x, y, z)]); });
}

/// The world of a caller's source of voxels. Thread-safe if the source is.
class SourceWorld final : public voxel::PyramidWorld {
public:
    /// @param limit_bytes of boxes that it keeps
    /// @throws util::UsageError for a source whose facts make no world
    SourceWorld(std::shared_ptr<VoxelSource> source, std::size_t limit_bytes)
        : PyramidWorld(limit_bytes),
          m_source(std::move(source)),
          m_info(make_info(m_source->info())) {}

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_info; }

protected:
    [[nodiscard]] voxel::FineColumn make_column(std::int32_t bx, std::int32_t bz) override {
        voxel::FineColumn out;
        const voxel::BoxRange range = voxel::boxes_over(m_info.bounds, 0);
        if (bx < range.min.bx || bx >= range.max.bx || bz < range.min.bz || bz >= range.max.bz)
            return out;
        out.by_begin = range.min.by;
        std::vector<Voxel> voxels(to_number(0, voxel::kBoxSizeY, 0));
        for (std::int32_t by = range.min.by; by < range.max.by; ++by) {
            std::fill(voxels.begin(), voxels.end(), Voxel{});
            const std::array<std::int32_t, 3> corner{bx * voxel::kBoxSizeX, by * voxel::kBoxSizeY,
                                                     bz * voxel::kBoxSizeZ};
            const bool any = m_source->fill(corner, voxels);
            out.boxes.push_back(any ? to_box({0, bx, by, bz}, voxels) : nullptr);
        }
        return out;
    }

private:
    const std::shared_ptr<VoxelSource> m_source;
    const voxel::WorldInfo m_info;
};

worlds::WorldOptions world_options(const scene::Scene& settings, const OpenOptions& options) {
    worlds::WorldOptions out = scene::to_world_options(settings);
    out.orthophotos.assign(options.orthophotos.begin(), options.orthophotos.end());
    out.additions = options.additions;
    out.cache_dir = util::cache_dir(options.cache);
    return out;
}

lidar::LasWritePoint written(const Point& point) {
    lidar::LasWritePoint out;
    out.x = point.x;
    out.y = point.y;
    out.z = point.z;
    out.intensity = point.intensity;
    out.return_number = point.return_number;
    out.return_count = point.return_count;
    out.classification = point.classification;
    out.rgb = point.rgb;
    return out;
}

/// Writes points to a LAZ file.
/// @return its path
std::string spool(PointSource& points, const std::filesystem::path& folder,
                  const Control& control) {
    constexpr int kWithColours = 7;
    constexpr double kStep_m = 0.001;
    std::vector<Point> batch;
    const auto next = [&] {
        check_stop(control);
        batch.clear();
        return points.next(batch);
    };
    bool more = next();
    while (more && batch.empty())
        more = next();
    if (!more)
        throw util::UsageError("voxelize points: there are none; allowed: at least 1");
    lidar::LasWriterOptions options;
    options.point_format = kWithColours;
    options.scale = {kStep_m, kStep_m, kStep_m};
    // Coordinates are whole numbers of steps from here, 2147 km to each side.
    options.offset = {std::floor(batch.front().x), std::floor(batch.front().y), 0};
    const std::filesystem::path file = folder / "points.laz";
    lidar::LasWriter writer(file, options);
    while (more) {
        for (const Point& point : batch)
            writer.write(written(point));
        more = next();
    }
    writer.close();
    return file;
}

}  // namespace

VoxelSource::~VoxelSource() = default;
PointSource::~PointSource() = default;

World World::open(const std::vector<std::string>& inputs, const OpenOptions& options,
                  const Control& control) {
    return guarded(control, [&] {
        set_up_log_once();
        const scene::Scene settings = make_settings(options);
        worlds::WorldOptions from = world_options(settings, options);
        from.inputs = inputs;
        const auto open = [&](util::StageTimes& times) {
            check_stop(control);
            return worlds::open_world(from, times, control.stop);
        };
        World out(make_state(settings, open));
        check_stop(control);
        return out;
    });
}

World World::of(std::shared_ptr<VoxelSource> source, const OpenOptions& options) {
    return guarded([&] {
        set_up_log_once();
        if (!source)
            throw util::UsageError("open a world of one's own: no source; allowed: one");
        if (!options.crs.empty() || !options.classes.empty() || options.voxel_m ||
            !options.orthophotos.empty() || !options.additions.empty())
            throw util::UsageError(
                "open a world of one's own: crs, classes, voxel_m, orthophotos or additions; "
                "allowed: fields, since a source says the rest itself");
        const scene::Scene settings = make_settings(options);
        const auto open = [&](util::StageTimes&) {
            return std::make_unique<SourceWorld>(
                source, static_cast<std::size_t>(settings.world.memory_mib) << 20);
        };
        return World(make_state(settings, open));
    });
}

World World::voxelize(PointSource& points, const OpenOptions& options, const Control& control) {
    return guarded(control, [&] {
        set_up_log_once();
        const scene::Scene settings = make_settings(options);
        auto folder = util::TemporaryFolder::make("voxelize points");
        worlds::WorldOptions from = world_options(settings, options);
        if (from.crs.empty())
            from.crs = points.crs();
        // Its name is another one each time.
        from.cache_dir.clear();
        from.inputs = {spool(points, folder.path(), control)};
        const auto open = [&](util::StageTimes& times) {
            return worlds::open_world(from, times, control.stop);
        };
        return World(make_state(settings, open, std::move(folder)));
    });
}

const WorldInfo& World::info() const noexcept {
    return m_state->info;
}

std::vector<std::string> World::damage() const {
    return guarded([&] { return m_state->world->damage(); });
}

VoxelBlock World::block_of(const std::optional<MapBounds>& bounds, int level) const {
    return guarded([&] {
        const voxel::VoxelBounds found = m_state->block_over(bounds, level);
        return VoxelBlock{level, found.min, found.max};
    });
}

}  // namespace terravox
