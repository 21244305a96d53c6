#include "raytracer/analyse/raster/cell_file.hpp"

#include <algorithm>
#include <string>
#include <type_traits>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "raytracer/core/output/tile_stream.hpp"

namespace terravox::analyse {
namespace {

template <class Band>
constexpr int measured_at(Band band) noexcept {
    static_assert(std::is_enum_v<Band>);
    return static_cast<int>(band);
}
constexpr int month_at(int month) noexcept {
    return measured_at(core::SunMonthsBand::kJanuary) + month - 1;
}

constexpr RasterBand kTerrainTable[] = {
    {"dsm", "m", measured_at(core::TerrainBand::kSurface)},
    {"dtm", "m", measured_at(core::TerrainBand::kGround)},
    {"ndsm", "m", kDerived},
    {"slope", "degree", kDerived},
    {"aspect", "degree", kDerived},
    {"hillshade", "", kDerived},
    {"class", "", measured_at(core::TerrainBand::kClass)},
    {"material", "", measured_at(core::TerrainBand::kMaterial)},
    {"red", "", measured_at(core::TerrainBand::kRed)},
    {"green", "", measured_at(core::TerrainBand::kGreen)},
    {"blue", "", measured_at(core::TerrainBand::kBlue)},
    {"dtm_source", "", kDerived},
    {"hole", "", measured_at(core::TerrainBand::kHole)},
};
constexpr RasterBand kSkyTable[] = {
    {"svf", "", measured_at(core::SkyBand::kCosine)},
    {"sky_view_solid", "", measured_at(core::SkyBand::kSolid)},
    {"openness", "degree", measured_at(core::SkyBand::kOpenness)},
    {"hole", "", measured_at(core::SkyBand::kHole)},
};
constexpr RasterBand kSunTable[] = {
    {"sun_hours", "h", measured_at(core::SunBand::kHours)},
    {"first_sun", "h", measured_at(core::SunBand::kFirst)},
    {"last_sun", "h", measured_at(core::SunBand::kLast)},
    {"hole", "", measured_at(core::SunBand::kHole)},
};
constexpr RasterBand kSunPeriodTable[] = {
    {"sun_hours", "h", measured_at(core::SunPeriodBand::kHours)},
    {"sun_hours_per_day", "h", measured_at(core::SunPeriodBand::kPerDay)},
    {"sun_share", "", measured_at(core::SunPeriodBand::kShare)},
    {"hole", "", measured_at(core::SunPeriodBand::kHole)},
};
constexpr RasterBand kSunMonthsTable[] = {
    {"sun_hours", "h", measured_at(core::SunMonthsBand::kHours)},
    {"january", "h", month_at(1)},
    {"february", "h", month_at(2)},
    {"march", "h", month_at(3)},
    {"april", "h", month_at(4)},
    {"may", "h", month_at(5)},
    {"june", "h", month_at(6)},
    {"july", "h", month_at(7)},
    {"august", "h", month_at(8)},
    {"september", "h", month_at(9)},
    {"october", "h", month_at(10)},
    {"november", "h", month_at(11)},
    {"december", "h", month_at(12)},
    {"hole", "", measured_at(core::SunMonthsBand::kHole)},
};
constexpr RasterBand kShadowTable[] = {
    {"sunlit", "", measured_at(core::ShadowBand::kSunlit)},
    {"hole", "", measured_at(core::ShadowBand::kHole)},
};
constexpr RasterBand kEnergyTable[] = {
    {"kwh_m2", "kWh/m2", measured_at(core::EnergyBand::kTotal)},
    {"beam", "kWh/m2", measured_at(core::EnergyBand::kBeam)},
    {"diffuse", "kWh/m2", measured_at(core::EnergyBand::kDiffuse)},
    {"reflected", "kWh/m2", measured_at(core::EnergyBand::kReflected)},
    {"slope", "degree", measured_at(core::EnergyBand::kSlope)},
    {"aspect", "degree", measured_at(core::EnergyBand::kAspect)},
    {"sun_hours", "h", measured_at(core::EnergyBand::kSunHours)},
    {"material", "", measured_at(core::EnergyBand::kMaterial)},
    {"hole", "", measured_at(core::EnergyBand::kHole)},
};
constexpr RasterBand kFacadeTable[] = {
    {"kwh_m2", "kWh/m2", measured_at(core::FacadeBand::kTotal)},
    {"beam", "kWh/m2", measured_at(core::FacadeBand::kBeam)},
    {"diffuse", "kWh/m2", measured_at(core::FacadeBand::kDiffuse)},
    {"reflected", "kWh/m2", measured_at(core::FacadeBand::kReflected)},
    {"sun_hours", "h", measured_at(core::FacadeBand::kSunHours)},
    {"sky_view", "", measured_at(core::FacadeBand::kSkyView)},
    {"azimuth", "degree", measured_at(core::FacadeBand::kAzimuth)},
    {"bottom", "m", measured_at(core::FacadeBand::kBottom)},
    {"height", "m", measured_at(core::FacadeBand::kHeight)},
    {"area", "m2", measured_at(core::FacadeBand::kArea)},
    {"hole", "", measured_at(core::FacadeBand::kHole)},
};
constexpr RasterBand kSightTable[] = {
    {"seen", "", measured_at(core::SightBand::kSeen)},
    {"distance_m", "m", measured_at(core::SightBand::kDistance)},
    {"class", "", measured_at(core::SightBand::kClass)},
    {"material", "", measured_at(core::SightBand::kMaterial)},
    {"hole", "", measured_at(core::SightBand::kHole)},
};

}  // namespace

std::span<const RasterBand> list_bands(core::AnalysisKind kind) noexcept {
    switch (kind) {
        case core::AnalysisKind::kNone:
        case core::AnalysisKind::kSunView: return {};
        case core::AnalysisKind::kTerrain: return kTerrainTable;
        case core::AnalysisKind::kSky: return kSkyTable;
        case core::AnalysisKind::kSun: return kSunTable;
        case core::AnalysisKind::kSunPeriod: return kSunPeriodTable;
        case core::AnalysisKind::kSunMonths: return kSunMonthsTable;
        case core::AnalysisKind::kShadow: return kShadowTable;
        case core::AnalysisKind::kEnergy: return kEnergyTable;
        case core::AnalysisKind::kFacade: return kFacadeTable;
        case core::AnalysisKind::kSight: return kSightTable;
    }
    return {};
}

int band_number(core::AnalysisKind kind, std::string_view name) {
    int number = 0;
    for (const RasterBand& band : list_bands(kind)) {
        ++number;
        if (band.name == name)
            return number;
    }
    throw util::Error("find the band " + std::string(name) + ": the analysis has none");
}

namespace {

constexpr int kTiffTiles = 16;

}  // namespace

CellFile::CellFile(const std::filesystem::path& out, core::AnalysisKind kind, int columns, int rows,
                   int tile_px)
    : m_kind(kind),
      m_columns(columns),
      m_rows(rows),
      m_block_px(output::file_tile_px(tile_px, kTiffTiles)),
      m_attempt("write the raster " + out.string()),
      m_file(std::filesystem::path(out).replace_extension(".cells.tif")) {
    if (m_block_px == 0)
        throw util::UsageError(m_attempt + ": --tile " + std::to_string(tile_px) +
                               "; allowed: multiples of 16");
    const output::GdalWatch watch(m_attempt);
    const auto bands = list_bands(kind);
    // Bands apart, so that those which are derived later rewrite none of the others.
    output::GdalOptions options = {{"TILED", "YES"},
                                   {"BLOCKXSIZE", std::to_string(m_block_px)},
                                   {"BLOCKYSIZE", std::to_string(m_block_px)},
                                   {"INTERLEAVE", "BAND"},
                                   {"COMPRESS", "DEFLATE"},
                                   {"ZLEVEL", "1"},
                                   {"PREDICTOR", "3"},
                                   {"BIGTIFF", "YES"}};
    m_dataset.reset(GDALCreate(GDALGetDriverByName("GTiff"),
                               m_file.temporary_path().string().c_str(), columns, rows,
                               static_cast<int>(bands.size()), GDT_Float32, options.list()));
    watch.check(m_dataset != nullptr);
    int number = 0;
    for (const RasterBand& band : bands) {
        GDALRasterBandH to = GDALGetRasterBand(m_dataset.get(), ++number);
        GDALSetDescription(to, std::string(band.name).c_str());
        watch.check(GDALSetRasterNoDataValue(to, static_cast<double>(core::kNoData)) == CE_None);
        if (!band.unit.empty())
            watch.check(GDALSetRasterUnitType(to, std::string(band.unit).c_str()) == CE_None);
    }
}

void CellFile::add(const tiles::TileResult& result) {
    const tiles::RenderTile& t = result.tile;
    const CellRectangle area{t.x0, t.y0, t.x1 - t.x0, t.y1 - t.y0};
    const auto cells = static_cast<std::size_t>(area.width) * static_cast<std::size_t>(area.height);
    const std::size_t count = core::band_count(m_kind);
    if (t.step != 1 || t.refines || t.x1 > m_columns || t.y1 > m_rows ||
        result.bands.size() != cells * count)
        throw util::Error(m_attempt + ": a tile of " + std::to_string(cells) + " cells has " +
                          std::to_string(result.bands.size()) + " values; allowed: " +
                          std::to_string(cells * count) + ", of a single pass");
    std::vector<float> values(cells);
    int number = 0;
    for (const RasterBand& band : list_bands(m_kind)) {
        ++number;
        if (band.measured == kDerived)
            continue;
        const auto from = static_cast<std::size_t>(band.measured);
        for (std::size_t i = 0; i < cells; ++i)
            values[i] = result.bands[i * count + from];
        write(number, area, values);
    }
}

void CellFile::read(int band, const CellRectangle& area, std::vector<float>& values) {
    const auto width = static_cast<std::size_t>(area.width);
    values.assign(width * static_cast<std::size_t>(area.height), core::kNoData);
    const int x0 = std::max(area.x0, 0);
    const int y0 = std::max(area.y0, 0);
    const int x1 = std::min(area.x0 + area.width, m_columns);
    const int y1 = std::min(area.y0 + area.height, m_rows);
    if (x0 >= x1 || y0 >= y1)
        return;
    const output::GdalWatch watch(m_attempt);
    float* to = values.data() + static_cast<std::size_t>(y0 - area.y0) * width +
                static_cast<std::size_t>(x0 - area.x0);
    watch.check(GDALRasterIOEx(GDALGetRasterBand(m_dataset.get(), band), GF_Read, x0, y0, x1 - x0,
                               y1 - y0, to, x1 - x0, y1 - y0, GDT_Float32, sizeof(float),
                               static_cast<GSpacing>(width * sizeof(float)), nullptr) == CE_None);
}

void CellFile::write(int band, const CellRectangle& area, std::vector<float>& values) {
    const output::GdalWatch watch(m_attempt);
    watch.check(GDALRasterIOEx(GDALGetRasterBand(m_dataset.get(), band), GF_Write, area.x0, area.y0,
                               area.width, area.height, values.data(), area.width, area.height,
                               GDT_Float32, 0, 0, nullptr) == CE_None);
}

void check_raster_target(const std::filesystem::path& out) {
    const std::string ending = util::lower_extension(out);
    if (ending != ".tif" && ending != ".tiff")
        throw util::UsageError("write the raster " + out.string() + ": the ending '" + ending +
                               "'; allowed: .tif .tiff");
    util::check_writable(out);
}

void write_raster(GDALDatasetH cells, const std::string& attempt, const std::filesystem::path& out,
                  const output::PictureInfo& info, int threads, bool has_floats) {
    const output::GdalWatch watch(attempt);
    output::describe_geotiff(cells, info, watch);
    GDALFlushCache(cells);
    util::AtomicFile target(out);
    output::CogOptions options;
    options.has_floats = has_floats;
    options.block_px = 256;
    options.overview_resampling = "NEAREST";
    options.threads = std::to_string(threads);
    output::write_cog(cells, target.temporary_path(), options, watch);
    target.commit();
}

void write_raster(CellFile& cells, const std::filesystem::path& out,
                  const output::PictureInfo& info, int threads) {
    write_raster(cells.dataset(), cells.attempt(), out, info, threads, true);
}

}  // namespace terravox::analyse
