#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "common/util/linear_light.hpp"
#include "tests/bench/bench.hpp"
#include "tests/bench/entries/data_sets.hpp"
#include "voxelserver/data/imagery/orthophotos.hpp"
#include "voxelserver/data/sunlight/exposure.hpp"
#include "voxelserver/make/voxelize/columns/point_set.hpp"
#include "voxelserver/make/voxelize/points/settings.hpp"
#include "voxelserver/make/voxelize/steps/photo_lights.hpp"

namespace terravox::bench::accuracy_strangers_photo_entry {
namespace {

const DataSet& bd_ortho() {
    static const DataSet set{"bd-ortho",
                             "1 file, 14,938 points, 50 x 100 m",
                             {"bd-ortho/792000_6272000-50mx100m-left.laz"},
                             {"bd-ortho/792000_6272000-50mx100m-left-patch-0000000.tiff"},
                             "",
                             "fr-lidarhd",
                             0.5};
    return set;
}

const DataSet& autzen() {
    static const DataSet set{"autzen",
                             "1 file, 110,000 points, 359 x 171 m",
                             {"pdal/laz/autzen_trim.laz"},
                             {"pdal/autzen/autzen.jpg"},
                             "",
                             "asprs",
                             1};
    return set;
}

/// Colours from above.
class Colours {
public:
    void add(const imagery::Raster& raster) {
        for (std::size_t i = 0; i < raster.colour.size(); ++i) {
            if ((raster.flags[i] & imagery::Raster::kColour) == 0)
                continue;
            const voxel::Rgb8& c = raster.colour[i];
            constexpr std::uint8_t kMost = 255;
            m_clipped += c.r == kMost || c.g == kMost || c.b == kMost ? 1 : 0;
            m_lightness.push_back(lightness(c));
        }
    }
    [[nodiscard]] double clipped() const {
        return m_clipped / static_cast<double>(std::max<std::size_t>(m_lightness.size(), 1));
    }
    [[nodiscard]] double median_lightness() {
        if (m_lightness.empty())
            return 0;
        const auto middle =
            m_lightness.begin() + static_cast<std::ptrdiff_t>(m_lightness.size() / 2);
        std::nth_element(m_lightness.begin(), middle, m_lightness.end());
        return *middle;
    }

private:
    /// L* of CIE 1976: [0, 100].
    static double lightness(const voxel::Rgb8& c) {
        const auto linear = [](std::uint8_t v) {
            return static_cast<float>(util::to_linear(v)) / util::kBrightest;
        };
        const auto y =
            static_cast<double>(sunlight::luminance({linear(c.r), linear(c.g), linear(c.b)}));
        constexpr double kLinearBelow = 0.008856;
        return y > kLinearBelow ? 116 * std::cbrt(y) - 16 : 903.3 * y;
    }
    double m_clipped = 0;
    std::vector<double> m_lightness;
};

/// A place with one photograph.
struct Place {
    Place(const DataSet& set, const Context& c)
        : options(options_of(set, c)),
          points(options, settings, times),
          photos(options.orthophotos, points.sources().frame),
          lights(photos, points, times) {}

    static voxelize::LidarWorldOptions options_of(const DataSet& set, const Context& c) {
        voxelize::LidarWorldOptions out;
        out.files = set.paths(c);
        out.orthophotos = set.orthophoto_paths(c);
        out.classes = set.classes;
        out.voxel_m = set.voxel_m;
        out.threads = c.threads;
        return out;
    }

    /// What is photographed and has points beneath.
    template <class Visit>
    void each_patch(const Visit& visit) {
        std::set<std::pair<std::int32_t, std::int32_t>> keys;
        for (const voxelize::SquareSource& file : points.sources().files) {
            const grid::ColumnRect common = file.bounds.common(photos.inputs().front().rect);
            if (common.area() == 0)
                continue;
            for (std::int32_t pz = common.min_z >> 6; pz <= (common.max_z - 1) >> 6; ++pz)
                for (std::int32_t px = common.min_x >> 6; px <= (common.max_x - 1) >> 6; ++px)
                    keys.emplace(px, pz);
        }
        for (const auto& [px, pz] : keys)
            visit(grid::PatchKey{px, pz});
    }

    voxelize::LidarWorldOptions options;
    voxelize::Settings settings;
    util::StageTimes times;
    voxelize::PointSet points;
    imagery::Orthophotos photos;
    voxelize::PhotoLights lights;
};

struct Named {
    sunlight::Known material;
    const char* name;
    double high;  ///< of a place
};
constexpr std::array kNamed{Named{sunlight::Known::kAsphalt, "asphalt", 0.2},
                            Named{sunlight::Known::kLeaves, "leaves", 0.3},
                            Named{sunlight::Known::kTiles, "tiles", 0.35}};

void measure(const DataSet& set, const Context& c, Readings& readings) {
    Place place(set, c);
    const voxelize::PhotoLight light = place.lights.make_light(0);
    const sunlight::Exposure exposure = sunlight::find_exposure(light.evidence);
    const std::string of = set.id + ": ";
    for (const Named& one : kNamed) {
        const sunlight::Sighting& seen = light.evidence.of(one.material);
        if (seen.cells == 0)
            continue;
        const std::string what = of + one.name;
        const auto before = static_cast<double>(seen.albedo[1]);
        const auto after = static_cast<double>(exposure.gain[1]) *
                           std::max(before - static_cast<double>(exposure.black[1]), 0.0);
        readings.add(what + " as before, green", "albedo", before);
        readings.add(what + ", green", "albedo", after, at_most(one.high));
    }
    readings.add(of + "exposure", "x", static_cast<double>(light.light.gain[1]));
    readings.add(of + "black point", "linear",
                 static_cast<double>(sunlight::luminance(light.light.veil)));
    Colours raw;
    Colours developed;
    place.each_patch([&](grid::PatchKey key) {
        raw.add(place.photos.read(key.x0(), key.z0(), grid::kPatchSize, grid::kPatchSize));
        developed.add(place.lights.albedo(key));
    });
    readings.add(of + "clipped, raw", "share", raw.clipped());
    readings.add(of + "clipped", "share", developed.clipped(), at_most(0.01));
    readings.add(of + "median lightness, raw", "L*", raw.median_lightness());
    readings.add(of + "median lightness", "L*", developed.median_lightness());
}

Entry entry() {
    Entry out;
    out.name = "accuracy/strangers-photo";
    out.measures =
        "photographs of strangers: albedo of asphalt, leaves and tiles, what is clipped, lightness";
    out.work =
        "a bright patch of the BD ORTHO (50 m, voxels of 0.5 m), Montpellier (50 m, 0.5 m) and "
        "Autzen (359 x 171 m, 1 m)";
    out.missing = [](const Context& c) {
        for (const DataSet* set : {&bd_ortho(), &montpellier(), &autzen()})
            if (const std::string reason = set->missing(c); !reason.empty())
                return reason;
        return std::string();
    };
    out.exact = true;
    out.prepare = [](const Context& c) -> Body {
        return [&c](Readings& readings) {
            for (const DataSet* set : {&bd_ortho(), &montpellier(), &autzen()})
                measure(*set, c, readings);
        };
    };
    return out;
}

const Registration kRegistered([] { return std::vector{entry()}; });

}  // namespace
}  // namespace terravox::bench::accuracy_strangers_photo_entry
