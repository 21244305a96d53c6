#include "voxelserver/make/voxelize/world/lidar_world.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "common/util/cache.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/voxel/box_builder.hpp"
#include "common/voxel/pyramid_world.hpp"
#include "voxelserver/make/voxelize/points/brightness.hpp"
#include "voxelserver/make/voxelize/points/options.hpp"
#include "voxelserver/make/voxelize/steps/photo_light.hpp"
#include "voxelserver/make/voxelize/steps/photo_mosaic.hpp"
#include "voxelserver/make/voxelize/world/box_column.hpp"
#include "voxelserver/make/voxelize/world/input_fingerprints.hpp"
#include "voxelserver/make/voxelize/world/world_facts.hpp"

namespace terravox::voxelize {
namespace {

using voxel::Box;
using voxel::BoxKey;
using voxel::BoxWithInputs;
using voxel::InputExtent;

// How the world's memory is divided; PointSet takes the rest (columns/square_reader.cpp).
constexpr std::size_t kColumnsShare = 10;
constexpr std::size_t kCoarseShare = 20;
constexpr std::size_t kMakerShare = 20;

class LidarWorldImpl final : public LidarWorld {
public:
    LidarWorldImpl(const LidarWorldOptions& options, util::StageTimes& times)
        : m_times(times),
          m_settings(load_settings(options.settings, options.steps, options.photo)),
          m_points(options, m_settings, times),
          m_images(options.orthophotos.empty() ? nullptr
                                               : std::make_unique<imagery::Orthophotos>(
                                                     options.orthophotos, m_points.sources().frame,
                                                     m_points.sources().named_squares)),
          m_maker(m_points, m_images.get(), m_settings, options.memory_bytes / kMakerShare, times),
          m_columns(options.memory_bytes / kColumnsShare),
          m_coarse(options.memory_bytes / kCoarseShare) {
        if (m_images)
            m_images->warn_of_outside(m_points.sources().bounds);
        gather_facts(options);
    }

    ~LidarWorldImpl() override {
        constexpr double kNearlyAll = 0.95;
        const auto holes = m_maker.hole_columns();
        if (m_maker.hole_share() >= kNearlyAll)
            util::log_warn(
                "{}: {:.0f} % of the area that the files claim is empty: perhaps their CRS is "
                "another one (--crs), or their bounds are wrong (terravox laz check)",
                m_facts.info.title, std::floor(100 * m_maker.hole_share()));
        else if (holes > 0)
            util::log_info(
                "{}: {} columns inside the files' bounds are holes: nothing was seen for {:.0f} m "
                "around",
                m_facts.info.title, holes, Land::kWidestGap_m);
        util::say_shared_warnings();
    }
    LidarWorldImpl(const LidarWorldImpl&) = delete;
    LidarWorldImpl& operator=(const LidarWorldImpl&) = delete;

    [[nodiscard]] const voxel::WorldInfo& info() const noexcept override { return m_facts.info; }

    [[nodiscard]] LidarWorldStats stats() const override {
        const Sources& sources = m_points.sources();
        return {sources.point_count,  sources.files.size(),       m_images ? m_images->count() : 0,
                m_facts.water_cell_m, m_points.counts().outliers, m_maker.hole_columns(),
                sources.flight_lines, m_points.classes().id};
    }

    [[nodiscard]] std::string known_squares(std::span<const std::string> also) const override {
        const Sources& sources = m_points.sources();
        KnownSquares all = sources.known;
        // A file that was renamed has its identity still, and is known as it is now.
        for (const std::string& identity : also)
            if (const KnownSquare* const before = sources.known_before.find(identity);
                before != nullptr && all.find(identity) == nullptr)
                all.add(*before);
        return all.to_bytes(way_of_opening(m_settings.points));
    }

    [[nodiscard]] std::set<std::size_t> rescaled_files(std::span<const grid::ColumnRect> changed,
                                                       bool scales_are_known) const override {
        std::set<std::size_t> out;
        if (!m_settings.steps.material_guesses)
            return out;
        const std::vector<SquareSource>& files = m_points.sources().files;
        for (std::size_t i = 0; i < files.size(); ++i)
            if (scales_are_known ? has_other_scale(files[i]) : may_share_scale(files[i], changed))
                out.insert(i);
        return out;
    }

    [[nodiscard]] std::optional<grid::ColumnRect> known_bounds(
        std::string_view identity) const override {
        const KnownSquare* const found = m_points.sources().known_before.find(identity);
        return found == nullptr ? std::nullopt : std::optional(found->bounds);
    }

    [[nodiscard]] std::vector<float> ground_heights(std::int32_t bx, std::int32_t bz) override {
        return m_maker.ground_heights({bx, bz});
    }

    [[nodiscard]] InputExtent reach(std::int32_t bx, std::int32_t bz) override {
        return m_maker.reach({bx, bz});
    }

    [[nodiscard]] InputExtent water_reach(std::int32_t bx, std::int32_t bz) override {
        return m_maker.water_reach({bx, bz});
    }

    [[nodiscard]] std::size_t ground_cells(std::int32_t bx, std::int32_t bz) override {
        const auto columns = m_points.columns({bx, bz});
        const std::vector<water::WaterCell>& cells = columns->cells.cells;
        return static_cast<std::size_t>(
            std::count_if(cells.begin(), cells.end(),
                          [](const water::WaterCell& cell) { return !std::isnan(cell.ground); }));
    }

    [[nodiscard]] std::int32_t shadow_patches() const noexcept override {
        return relights() ? voxelize::shadow_patches(m_facts.info.voxel_m) : 0;
    }

    [[nodiscard]] std::vector<grid::ColumnRect> photographs_with_light_from(
        const std::set<std::size_t>& files) const override {
        std::vector<grid::ColumnRect> out;
        if (!relights())
            return out;
        const std::vector<imagery::Orthophotos::Input> images = m_images->inputs();
        std::vector<bool> changed;
        for (const imagery::Orthophotos::Input& image : images) {
            const PhotoSample sample = photo_sample(image.rect, m_points.sources());
            changed.push_back(std::any_of(sample.files.begin(), sample.files.end(),
                                          [&](std::size_t file) { return files.contains(file); }));
        }
        const PhotoMosaic mosaic(images);
        const ExposureImages exposure = exposure_images(images);
        for (std::size_t i = 0; i < images.size(); ++i) {
            const auto any_changed = [&](const std::vector<std::size_t>& of) {
                return std::any_of(of.begin(), of.end(),
                                   [&](std::size_t other) { return changed[other]; });
            };
            if (any_changed(mosaic.around(i)) || any_changed(exposure.at(images[i].series)))
                out.push_back(images[i].rect);
        }
        return out;
    }

    [[nodiscard]] std::vector<Tree> trees(std::int32_t bx, std::int32_t bz) override {
        return m_maker.trees({bx, bz});
    }

    [[nodiscard]] std::vector<SquareInfo> squares() const override {
        std::vector<SquareInfo> out = m_facts.squares;
        for (std::size_t i = 0; i < out.size(); ++i)
            std::tie(out[i].state, out[i].error) = m_points.find_state(i);
        return out;
    }

    [[nodiscard]] const WorldFacts& facts() const noexcept override { return m_facts; }

    [[nodiscard]] voxel::Fingerprint fingerprint(const InputExtent& reach) const override {
        return m_facts.fingerprint(reach);
    }

    [[nodiscard]] std::shared_ptr<const Box> box(const BoxKey& key) override {
        return box_with_inputs(key).box;
    }

    [[nodiscard]] BoxWithInputs box_with_inputs(const BoxKey& key) override {
        voxel::check_level(m_facts.info, key.level);
        if (!m_facts.touches_land(key.level, key.bx, key.bz))
            return {nullptr, footprint(key)};
        if (!voxel::boxes_over(m_facts.info.bounds, key.level).contains(key))
            return {nullptr, water::kAnywhere};  // because of the heights of all files
        if (key.level > 0)
            return coarse_box(key);
        const auto column = m_columns.get(
            BoxKey{0, key.bx, 0, key.bz},
            [&] { return std::make_shared<BoxColumn>(m_maker.make({key.bx, key.bz})); },
            [](const auto& c) { return c->memory_bytes(); });
        const std::int64_t index = std::int64_t{key.by} - column->by_begin;
        const bool inside = index >= 0 && index < static_cast<std::int64_t>(column->boxes.size());
        return {inside ? column->boxes[static_cast<std::size_t>(index)] : nullptr, column->reach};
    }

    [[nodiscard]] voxel::ColumnExtent column(int level, std::int32_t bx, std::int32_t bz) override {
        return m_facts.column(level, bx, bz);
    }

private:
    [[nodiscard]] bool relights() const noexcept {
        return m_images != nullptr && m_settings.orthophoto.albedo;
    }

    /// The scale depends on the points alone, not on an index file next to theirs.
    [[nodiscard]] bool has_other_scale(const SquareSource& file) const {
        const KnownSquares& before = m_points.sources().known_before;
        const KnownSquare* then = before.find(file.identity, file.side_identity);
        if (then == nullptr)
            then = before.find(file.identity);
        return then == nullptr || then->brightness != file.brightness;
    }

    /// A file without echoes has no scale, whatever lies near it.
    [[nodiscard]] bool may_share_scale(const SquareSource& file,
                                       std::span<const grid::ColumnRect> changed) const {
        const KnownSquare* const known =
            m_points.sources().known.find(file.identity, file.side_identity);
        const auto near = static_cast<std::int32_t>(kSharedScale_m / m_facts.info.voxel_m) + 1;
        return known != nullptr && known->has_echoes &&
               std::any_of(changed.begin(), changed.end(), [&](const grid::ColumnRect& rect) {
                   return rect.grown(near).overlaps(file.bounds);
               });
    }

    void gather_facts(const LidarWorldOptions& options) {
        const Sources& sources = m_points.sources();
        const grid::Frame& frame = sources.frame;
        voxel::WorldInfo& info = m_facts.info;
        info.title = world_title(options);
        info.licence = options.licence;
        info.attribution = options.attribution;
        info.bounds.min = {sources.bounds.min_x, sources.lowest_y, sources.bounds.min_z};
        info.bounds.max = {sources.bounds.max_x, sources.highest_y, sources.bounds.max_z};
        info.typical_heights = sources.typical_heights;
        info.voxel_m = frame.voxel_m();
        info.crs = frame.crs().name();
        info.crs_wkt = frame.crs().wkt();
        info.crs_units_per_voxel = frame.units_per_voxel();
        info.centre = geo::map_place(
            frame.crs(), frame.easting((info.bounds.min[0] + info.bounds.max[0]) / 2.0),
            frame.northing((info.bounds.min[2] + info.bounds.max[2]) / 2.0));
        // Levels until the whole world fits in one box.
        const std::int32_t widest = std::max(info.bounds.max[0] - info.bounds.min[0],
                                             info.bounds.max[2] - info.bounds.min[2]);
        while (info.levels < voxel::kMaxLevel && (voxel::kBoxSizeX << (info.levels - 1)) < widest)
            ++info.levels;

        for (const SquareSource& s : sources.files) {
            m_facts.islands.insert(m_facts.islands.end(), s.islands.begin(), s.islands.end());
            m_facts.squares.push_back({s.info.path.stem().string(),
                                       s.info.path,
                                       s.bounds,
                                       s.info.point_count,
                                       s.info.file_bytes,
                                       SquareState::kFetched,
                                       {}});
        }
        m_facts.orthophotos = m_images ? m_images->count() : 0;
        m_facts.water_cell_m = m_points.cell_voxels() * frame.voxel_m();
        m_facts.fingerprints = make_fingerprints(sources, m_images.get(), m_points.classes(),
                                                 m_settings, m_points.cell_voxels());
    }

    // The footprint of a box: where there is nothing, a file may be added.
    [[nodiscard]] static InputExtent footprint(const BoxKey& key) noexcept {
        const auto edge = [&](std::int64_t b) {
            return static_cast<std::int32_t>(std::clamp<std::int64_t>(
                b << key.level, water::kAnywhere.min_bx, water::kAnywhere.max_bx));
        };
        return {edge(key.bx), edge(key.bz), edge(std::int64_t{key.bx} + 1),
                edge(std::int64_t{key.bz} + 1)};
    }

    // Children above and below the world are air because those between are all that can exist:
    // their dependencies need not be queried.
    [[nodiscard]] BoxWithInputs child(const BoxKey& key) {
        return voxel::boxes_over(m_facts.info.bounds, key.level).contains(key)
                   ? box_with_inputs(key)
                   : BoxWithInputs{nullptr, footprint(key)};
    }

    BoxWithInputs coarse_box(const BoxKey& key) {
        return *m_coarse.get(
            key,
            [&] {
                BoxWithInputs out{nullptr, footprint(key)};
                const auto children = voxel::Pyramid::children(key, [&](const BoxKey& below) {
                    BoxWithInputs made = child(below);
                    out.reach.add(made.reach);
                    return std::move(made.box);
                });
                const util::StageTimes::Scope scope(m_times, "downsample");
                out.box = voxel::downsample(key, children);
                return std::make_shared<const BoxWithInputs>(std::move(out));
            },
            [](const auto& b) {
                return sizeof *b + (b->box ? b->box->memory_bytes() : std::size_t{0});
            });
    }

    util::StageTimes& m_times;
    const Settings m_settings;
    PointSet m_points;
    const std::unique_ptr<imagery::Orthophotos> m_images;
    BoxColumnMaker m_maker;
    WorldFacts m_facts;
    util::Cache<BoxKey, BoxColumn, voxel::BoxKeyHash> m_columns;
    util::Cache<BoxKey, BoxWithInputs, voxel::BoxKeyHash> m_coarse;
};

}  // namespace

std::unique_ptr<LidarWorld> open_lidar_world(const LidarWorldOptions& options,
                                             util::StageTimes& times) {
    // What files of another world share is nothing of this one, and what those of this one share is
    // said when it is open: whoever opens it may never end.
    util::say_shared_warnings();
    auto out = std::make_unique<LidarWorldImpl>(options, times);
    util::say_shared_warnings();
    return out;
}

}  // namespace terravox::voxelize
