// Orthophotos taken in the sun: albedo or raw, the same whatever is asked for first, and
// fingerprints that say on what a box depends. Photographs that are too bright.
// The surface that casts shadows on photographs: without gaps, whichever patches are asked for.
#include "common/geo/gdal.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <random>

#include <gdal_priv.h>

#include "common/util/linear_light.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/make/voxelize/world/cloud.hpp"
#include "voxelserver/data/imagery/orthophotos.hpp"
#include "voxelserver/make/voxelize/columns/point_set.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/steps/photo_lights.hpp"
#include "voxelserver/tools/survey/geotiff.hpp"
#include "voxelserver/tools/survey/survey.hpp"

using namespace terravox;
using namespace terravox::test;
namespace fs = std::filesystem;

namespace {

/// A part of the synthetic village, photographed in the sun; its squares side by side.
class Village {
public:
    /// Made once for each number of squares.
    static const Village& of(int squares) {
        static std::map<int, std::unique_ptr<const Village>> made;
        std::unique_ptr<const Village>& out = made[squares];
        if (!out)
            out.reset(new Village(squares));
        return *out;
    }
    [[nodiscard]] voxelize::LidarWorldOptions options(const std::string& photo,
                                                      int threads = 1) const {
        voxelize::LidarWorldOptions out;
        for (const std::string& name : m_names) {
            out.files.push_back(m_folder.path() / (name + ".laz"));
            out.orthophotos.push_back(m_folder.path() / "ortho" / (name + ".tif"));
        }
        out.photo = photo;
        out.threads = threads;
        return out;
    }
    /// The photographs with a gain and a veil, in linear light, of white.
    [[nodiscard]] voxelize::LidarWorldOptions photographed_with(const fs::path& folder, double gain,
                                                                double veil) const {
        auto out = options("");
        for (std::size_t i = 0; i < m_names.size(); ++i) {
            survey::SquareRaster<std::uint8_t> raster = read_pixels(out.orthophotos[i]);
            for (std::uint8_t& value : raster.pixels)
                value = util::to_srgb(static_cast<std::uint32_t>(
                    std::min(gain * util::to_linear(value) + veil * util::kBrightest,
                             static_cast<double>(util::kBrightest))));
            const fs::path copy = folder / out.orthophotos[i].filename();
            survey::write_geotiff(
                copy, {kEast_m + kSquare_m * static_cast<std::int32_t>(i), kNorth_m, kSquare_m},
                raster);
            out.orthophotos[i] = copy;
        }
        return out;
    }
    [[nodiscard]] voxelize::LidarWorldOptions truth() const {
        auto out = options("raw");
        out.orthophotos = {m_folder.path() / "truth" / ("albedo_" + m_names.front() + ".tif")};
        return out;
    }

private:
    static constexpr std::int32_t kSquare_m = 256;
    static constexpr std::int32_t kEast_m = 462528;
    static constexpr std::int32_t kNorth_m = 101296;

    static survey::SquareRaster<std::uint8_t> read_pixels(const fs::path& file) {
        geo::start_gdal();
        const GDALDatasetUniquePtr image{GDALDataset::Open(file.c_str(), GDAL_OF_RASTER)};
        REQUIRE(image);
        const int side = image->GetRasterXSize();
        survey::SquareRaster<std::uint8_t> out{side, 3, {}};
        out.pixels.resize(std::size_t{3} * static_cast<std::size_t>(side) *
                          static_cast<std::size_t>(side));
        REQUIRE(image->RasterIO(GF_Read, 0, 0, side, side, out.pixels.data(), side, side, GDT_Byte,
                                3, nullptr, 3, GSpacing{3} * side, 1, nullptr) == CE_None);
        return out;
    }

    explicit Village(int squares) {
        survey::SurveyOptions options;
        options.density = 4;
        options.square_m = kSquare_m;
        options.squares_east = squares;
        options.origin_east_m = kEast_m;
        options.origin_north_m = kNorth_m;
        options.photo_light = survey::PhotoLight{150, 40, 0, 0};
        options.threads = 2;
        options.folder = m_folder.path();
        for (const auto& square :
             survey::run_survey(options, [](const survey::SquareReport&, std::size_t) {}))
            m_names.push_back(square.name);
    }
    TemporaryFolder m_folder;
    std::vector<std::string> m_names;
};

/// Mean difference of the colours of top voxels, in 8-bit steps.
double green_difference(OpenWorld& a, OpenWorld& b) {
    const auto& bounds = a.world().info().bounds;
    double sum = 0;
    double count = 0;
    for (std::int32_t z = bounds.min[2]; z < bounds.max[2]; z += 3)
        for (std::int32_t x = bounds.min[0]; x < bounds.max[0]; x += 3) {
            const auto of_a = a.top_voxel(x, z);
            const auto of_b = b.top_voxel(x, z);
            if (!of_a || !of_b || !of_a->has_colour() || !of_b->has_colour())
                continue;
            sum += std::abs(of_a->colour.g - of_b->colour.g);
            ++count;
        }
    REQUIRE(count > 1000);
    return sum / count;
}

/// Median L* of the green of top voxels seen from above.
double median_lightness(OpenWorld& open) {
    const auto& bounds = open.world().info().bounds;
    std::vector<std::uint8_t> green;
    for (std::int32_t z = bounds.min[2]; z < bounds.max[2]; z += 3)
        for (std::int32_t x = bounds.min[0]; x < bounds.max[0]; x += 3)
            if (const auto top = open.top_voxel(x, z); top && top->has_colour())
                green.push_back(top->colour.g);
    REQUIRE(green.size() > 1000);
    const auto middle = green.begin() + static_cast<std::ptrdiff_t>(green.size() / 2);
    std::nth_element(green.begin(), middle, green.end());
    return 116 * std::cbrt(static_cast<double>(util::to_linear(*middle)) / util::kBrightest) - 16;
}

constexpr double kTower_m = 160;
constexpr int kGap = 20;  // columns

grid::PatchKey patch_at(double east, double north) {
    return {voxel_x(east) >> 6, voxel_z(north) >> 6};
}

/// Rough land of 400 x 400 m with more gaps than points, and a tower on it. East of the patch at
/// its middle there is nothing for kGap columns, and then a terrace.
class RoughLand {
public:
    RoughLand() : m_points(written(m_folder.path() / "land.laz"), m_settings, m_times) {}
    [[nodiscard]] voxelize::PointSet& points() { return m_points; }

private:
    static voxelize::LidarWorldOptions written(const std::filesystem::path& file) {
        std::mt19937 random(7);
        Cloud cloud;
        const std::int32_t border = (patch_at(200, 200).px + 1) * grid::kPatchSize;
        cloud.cover(0, 0, 400, 400, 1, 2, [&](double east, double) {
            const auto number = random();
            const int past = voxel_x(east) - border;
            if (number % 3 != 0 || (past >= 0 && past < kGap))
                return std::nan("");
            return (past < 0 ? 100 : 200) + static_cast<double>(number >> 8 & 7);
        });
        cloud.cover(300, 200, 306, 206, 0.5, 6, [](double, double) { return 100 + kTower_m; });
        cloud.write(file);
        return OpenWorld::with(file);
    }

    TemporaryFolder m_folder;
    util::StageTimes m_times;
    voxelize::Settings m_settings;
    voxelize::PointSet m_points;
};

grid::PatchRect grown(grid::PatchKey key, std::int32_t by) {
    return {{key.px - by, key.pz - by}, {key.px + 1 + by, key.pz + 1 + by}};
}

}  // namespace

TEST_CASE("an orthophoto's shadows are taken out of the colours of voxels, unless raw is asked for",
          "[voxelserver][voxelize][photo-light]") {
    const Village& village = Village::of(1);
    OpenWorld usual(village.options(""));
    OpenWorld raw(village.options("raw"));
    OpenWorld truth(village.truth());
    const double before = green_difference(raw, truth);
    const double after = green_difference(usual, truth);
    CAPTURE(before, after);
    CHECK(after < before / 2);
    CHECK_THROWS_WITH(OpenWorld(village.options("grey")),
                      contains("--photo") && contains("'grey'") && contains("albedo, raw"));
}

TEST_CASE("photographs that are too bright or veiled give the colours of right ones",
          "[voxelserver][voxelize][photo-light]") {
    struct Case {
        const char* name;
        double gain;
        double veil;
    };
    const auto c = GENERATE(values<Case>({{"too bright", 2, 0}, {"too bright, veiled", 1.6, 0.1}}));
    const Village& village = Village::of(1);
    const TemporaryFolder folder;
    auto options = village.photographed_with(folder.path(), c.gain, c.veil);
    DYNAMIC_SECTION(c.name) {
        OpenWorld right(village.options(""));
        OpenWorld developed(options);
        options.photo = "raw";
        OpenWorld raw(options);
        const double before = green_difference(raw, right);
        const double after = green_difference(developed, right);
        CAPTURE(before, after);
        CHECK(after < before / 3);
        CHECK(after < 15);
        CHECK(median_lightness(developed) == Approx(median_lightness(right)).epsilon(0.1));
    }
}

TEST_CASE("photographs of one flight have one exposure, and right ones that of their own light",
          "[voxelserver][voxelize][photo-light]") {
    const Village& village = Village::of(2);
    const TemporaryFolder folder;
    const auto lights_by = [](const voxelize::LidarWorldOptions& options) {
        const voxelize::Settings settings;
        util::StageTimes times;
        voxelize::PointSet points(options, settings, times);
        const imagery::Orthophotos photos(options.orthophotos, points.sources().frame);
        voxelize::PhotoLights lights(photos, points, times);
        return std::array{lights.make_light(0), lights.make_light(1)};
    };
    const auto right = lights_by(village.options(""));
    const auto bright = lights_by(village.photographed_with(folder.path(), 2.5, 0));
    for (const voxelize::PhotoLight& light : right)
        CHECK(light.light.gain[1] == Approx(1).margin(0.1));
    for (const voxelize::PhotoLight& light : bright)
        CHECK(light.light.gain[1] == Approx(0.4).epsilon(0.35));
    CHECK(bright[0].light.gain[1] == Approx(bright[1].light.gain[1]).epsilon(0.1));
}

TEST_CASE("raw and albedo have other fingerprints, and albedo reaches as far as shadows",
          "[voxelserver][voxelize][photo-light]") {
    const Village& village = Village::of(1);
    OpenWorld albedo(village.options("albedo"));
    OpenWorld usual(village.options(""));
    OpenWorld raw(village.options("raw"));
    const auto range = voxel::boxes_over(albedo.world().info().bounds, 0);
    const voxel::InputExtent everywhere{range.min.bx, range.min.bz, range.max.bx, range.max.bz};
    CHECK(albedo.world().fingerprint(everywhere) == usual.world().fingerprint(everywhere));
    CHECK_FALSE(albedo.world().fingerprint(everywhere) == raw.world().fingerprint(everywhere));
    // The shadows on a box come from the patches around it.
    const voxel::BoxKey middle{0, (range.min.bx + range.max.bx) / 2, range.min.by,
                               (range.min.bz + range.max.bz) / 2};
    const auto wide = albedo.world().box_with_inputs(middle).reach;
    const auto narrow = raw.world().box_with_inputs(middle).reach;
    CHECK(wide.min_bx <= narrow.min_bx - 1);
    CHECK(wide.max_bz >= narrow.max_bz + 1);
}

TEST_CASE("two photographs of one flight have the same light where they meet",
          "[voxelserver][voxelize][photo-light]") {
    const Village& village = Village::of(2);
    const voxelize::Settings settings;
    util::StageTimes times;
    const voxelize::LidarWorldOptions options = village.options("");
    voxelize::PointSet points(options, settings, times);
    const imagery::Orthophotos photos(options.orthophotos, points.sources().frame);
    voxelize::PhotoLights lights(photos, points, times);
    REQUIRE(lights.make_light(0).light.sun);
    REQUIRE(lights.make_light(1).light.sun);
    // Each finds a little of its own.
    CHECK(lights.make_light(0).light.sky != lights.make_light(1).light.sky);
    const grid::ColumnRect west = photos.inputs()[0].rect;
    for (std::int32_t pz = west.min_z >> 6; pz <= (west.max_z - 1) >> 6; ++pz) {
        const grid::PatchKey border{(west.max_x - 2) >> 6, pz};
        const sunlight::LightField of_west = lights.light_over(0, border);
        const sunlight::LightField of_east = lights.light_over(1, border);
        CHECK(of_west.middle.sun->azimuth_deg == of_east.middle.sun->azimuth_deg);
        CHECK(of_west.middle.sky == of_east.middle.sky);
        CHECK(of_west.at(0.3F, 0.8F).sky == of_east.at(0.3F, 0.8F).sky);
        CHECK(of_west.at(0.3F, 0.8F).gain == of_east.at(0.3F, 0.8F).gain);
        // It goes on without a step into the next patch.
        const sunlight::LightField next = lights.light_over(1, {border.px + 1, pz});
        CHECK(of_west.at(1, 0.5F).sky[1] == Approx(next.at(0, 0.5F).sky[1]));
        CHECK(of_west.at(1, 0.5F).veil[1] == Approx(next.at(0, 0.5F).veil[1]).margin(1e-6));
    }
}

TEST_CASE("the light of a photograph counts in those beside it",
          "[voxelserver][voxelize][photo-light]") {
    const Village& village = Village::of(2);
    auto alone = village.options("albedo");
    alone.orthophotos.pop_back();
    OpenWorld both(village.options("albedo"));
    OpenWorld west(alone);
    // Boxes in the west of the western photograph.
    const auto range = voxel::boxes_over(both.world().info().bounds, 0);
    const voxel::InputExtent western{range.min.bx, range.min.bz, range.min.bx + 1, range.max.bz};
    CHECK_FALSE(both.world().fingerprint(western) == west.world().fingerprint(western));
    auto raw = village.options("raw");
    OpenWorld raw_both(raw);
    raw.orthophotos.pop_back();
    OpenWorld raw_west(raw);
    CHECK(raw_both.world().fingerprint(western) == raw_west.world().fingerprint(western));
}

TEST_CASE("a photograph far away counts by its exposure, and so do the points beneath it",
          "[voxelserver][voxelize][photo-light]") {
    const Village& village = Village::of(4);
    OpenWorld all(village.options("albedo"));
    const auto& bounds = all.world().info().bounds;
    const auto range = voxel::boxes_over(bounds, 0);
    const voxel::InputExtent western{range.min.bx, range.min.bz, range.min.bx + 1, range.max.bz};
    auto without = village.options("albedo");
    without.orthophotos.pop_back();
    OpenWorld three(without);
    CHECK_FALSE(all.world().fingerprint(western) == three.world().fingerprint(western));
    // Where a file changes, the light of all that are exposed by it is to be found again.
    CHECK(all.world().photographs_with_light_from({3}).size() == 4);
    CHECK(all.world().photographs_with_light_from({}).empty());
}

TEST_CASE("albedo depends neither on threads nor on order, and its light is kept for later worlds",
          "[voxelserver][voxelize][photo-light]") {
    const TemporaryFolder cache;
    const TemporaryFolder lasting;
    const auto boxes = [](const voxelize::LidarWorldOptions& options) {
        OpenWorld world(options);
        auto keys = all_keys(world.info(), 0);
        if (options.threads > 1)
            std::reverse(keys.begin(), keys.end());
        return checksums(world.world(), keys);
    };
    auto options = Village::of(1).options("albedo", 1);
    const Checksums wanted = boxes(options);
    CHECK(wanted.size() > 10);
    CHECK((boxes(Village::of(1).options("albedo", 2)) == wanted));

    options.cache_dir = cache.path();
    const auto known_lights = [&] {
        std::vector<fs::path> out;
        for (const auto& file : fs::directory_iterator(cache.path() / "squares"))
            if (file.path().extension() == ".facts")
                out.push_back(file.path());
        return out;
    };
    CHECK((boxes(options) == wanted));
    REQUIRE(known_lights().size() == 1);
    const fs::path kept = known_lights().front();
    const std::string name = kept.stem().string();
    store::SquareFolder folder(cache.path() / "squares", 1 << 30);
    const auto facts = folder.find_facts(name);
    REQUIRE(facts);

    // Other settings find a light of their own.
    auto coarser = options;
    coarser.voxel_m = 2;
    (void)boxes(coarser);
    CHECK(known_lights().size() == 2);

    // It is kept with the chunk indices where these are to last.
    auto to_last = options;
    to_last.chunk_indices = lasting.path();
    CHECK((boxes(to_last) == wanted));
    CHECK(store::SquareFolder(lasting.path(), 1 << 30).find_facts(name) == facts);

    // What is damaged is found again.
    fs::resize_file(kept, fs::file_size(kept) - 1);
    CHECK((boxes(options) == wanted));
    CHECK(folder.find_facts(name) == facts);

    // It is what later worlds go by.
    auto light = voxelize::parse_photo_light(*facts);
    REQUIRE(light);
    light->light.gain = {0.5F, 0.5F, 0.5F};
    folder.put_facts(name, to_bytes(*light));
    CHECK((boxes(options) != wanted));
}

TEST_CASE("a patch's surface is filled from all around it, whatever is asked for with it",
          "[voxelserver][voxelize][photo-light]") {
    RoughLand land;
    voxelize::PhotoSurface surface(land.points());
    const grid::PatchKey key = patch_at(200, 200);
    const sunlight::Surface alone = surface.around(grown(key, 0), 2);
    const sunlight::Surface together = surface.around(grown(key, 1), 1);
    REQUIRE(alone.size() == together.size());
    constexpr int kReach = voxelize::PhotoSurface::kFilledTogether;
    int filled = 0;
    for (int z = alone.margin - kReach; z < alone.height - alone.margin + kReach; ++z)
        for (int x = alone.margin - kReach; x < alone.width - alone.margin + kReach; ++x) {
            const std::size_t i = alone.index(x, z);
            REQUIRE(alone.top_m[i] == together.top_m[i]);
            REQUIRE(alone.kind[i] == together.kind[i]);
            // Means of whole metres, where there was a gap.
            filled += alone.top_m[i] != std::floor(alone.top_m[i]) ? 1 : 0;
        }
    CHECK(filled > 1000);
    // From the patch, and not from the terrace, which lies in the same patch as these cells.
    const int border = alone.width - alone.margin;
    for (int z = alone.margin; z < alone.height - alone.margin; ++z) {
        INFO(z);
        const auto top_at = [&](int past) { return alone.top_m[alone.index(border + past, z)]; };
        for (int past = 0; past < kReach; ++past) {
            CHECK(top_at(past) > 99);
            CHECK(top_at(past) < 110);
        }
        // A wide gap farther away casts no shadow, whatever stands next to it.
        for (int past = kReach; past < kGap - sunlight::kSmallGap; ++past)
            CHECK(top_at(past) < -1000);
    }
}

TEST_CASE("a surface is as large as was asked for, and has what casts a shadow from another patch",
          "[voxelserver][voxelize][photo-light]") {
    RoughLand land;
    voxelize::PhotoSurface surface(land.points());
    const grid::PatchKey corner = patch_at(0, 400);
    const grid::PatchRect asked{{corner.px - 3, corner.pz - 2}, {corner.px + 1, corner.pz + 1}};
    const sunlight::Surface beyond = surface.around(asked, 1);
    CHECK(beyond.width == 6 * grid::kPatchSize);
    CHECK(beyond.height == 5 * grid::kPatchSize);
    CHECK(beyond.margin == grid::kPatchSize);
    CHECK(beyond.top_m.front() < -1000);
    CHECK(beyond.top_m[beyond.index(beyond.width - 70, beyond.height - 70)] > 99);
    const grid::PatchKey key = patch_at(200, 200);
    constexpr int kMargin = 2;
    const sunlight::Surface all = surface.around(grown(key, 0), kMargin);
    CHECK(std::ranges::none_of(all.top_m, [](float top) { return std::isnan(top); }));
    const int x = voxel_x(303) - (key.px - kMargin) * grid::kPatchSize;
    const int z = voxel_z(203) - (key.pz - kMargin) * grid::kPatchSize;
    CHECK(all.top_m[all.index(x, z)] == Approx(100 + kTower_m).margin(1));
}
