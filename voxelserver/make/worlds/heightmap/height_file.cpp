#include "voxelserver/make/worlds/heightmap/height_file.hpp"

#include <gdal_utils.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <string_view>

#include "common/geo/gdal_files.hpp"
#include "common/geo/gdal_messages.hpp"
#include "common/geo/raster_gate.hpp"
#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "voxelserver/data/grid/frame.hpp"

namespace terravox::heightmap {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
constexpr double kLowest_m = -12000,
                 kHighest_m = 10000;  // of the Earth; what lies beyond is no height

// A unit of height by its name, metres.
std::optional<double> to_unit(const std::string& written) {
    const std::string name = util::lower_case(written);
    struct Unit {
        const char* name;
        double metres;
    };
    static constexpr Unit kUnits[] = {{"m", 1},
                                      {"metre", 1},
                                      {"meter", 1},
                                      {"metres", 1},
                                      {"meters", 1},
                                      {"cm", 0.01},
                                      {"mm", 0.001},
                                      {"km", 1000},
                                      {"dm", 0.1},
                                      {"ft", 0.3048},
                                      {"foot", 0.3048},
                                      {"feet", 0.3048},
                                      {"international foot", 0.3048},
                                      {"us survey foot", 1200.0 / 3937},
                                      {"us-ft", 1200.0 / 3937},
                                      {"ftus", 1200.0 / 3937},
                                      {"foot_us", 1200.0 / 3937}};
    for (const Unit& unit : kUnits)
        if (name == unit.name)
            return unit.metres;
    return std::nullopt;
}

}  // namespace

std::string fault_of_heights(GDALDataset& raster) {
    const int bands = raster.GetRasterCount();
    GDALRasterBand& band = *raster.GetRasterBand(1);
    if (bands > 2 ||
        (bands == 2 && raster.GetRasterBand(2)->GetColorInterpretation() != GCI_AlphaBand))
        return "it has " + std::to_string(bands) + " bands, and heights have one, or alpha besides";
    if (GDALDataTypeIsComplex(band.GetRasterDataType()) != 0)
        return "its values are complex; allowed: whole or floating-point numbers";
    // Heights below 256 fit into a byte; so do grey pictures, in formats of pictures.
    const std::string_view format = raster.GetDriverName();
    const bool is_picture = band.GetRasterDataType() == GDT_Byte &&
                            (format == "JPEG" || format == "PNG" || format == "JP2OpenJPEG");
    if (is_picture || band.GetColorTable() != nullptr)
        return "its values are colours, no heights";
    return {};
}

void HeightFile::fail(const std::string& what) const {
    throw util::Error("read the heights of {}: {}", m_reading.path.string(), what);
}

HeightFile::HeightFile(const Reading& reading) : m_reading(reading) {
    const geo::GdalErrorScope errors;
    open();
    if (m_reading.warped_to)
        warp();
    learn();
    learn_values();
}

void HeightFile::open() {
    m_source = geo::open_raster(m_reading.path, "read the heights of");
    m_data = m_source.get();
    // GDAL reads this side file of a few formats alone.
    if (!m_reading.crs && m_source->GetSpatialRef() == nullptr)
        m_reading.crs = geo::Crs::from_side_file(path());
}

// Uses GDAL's warper on the fly: nothing is written. Blocks of the warped raster are made as a
// whole, so cells do not depend on the order of requests.
void HeightFile::warp() {
    // GDAL would take its coordinates for those of the other system.
    if (!m_reading.crs && geo::Crs::placing(m_source->GetSpatialRef()) == nullptr)
        fail("no coordinate reference system, from which it could be warped");
    const std::string to = m_reading.warped_to->wkt();
    const std::string from = m_reading.crs ? m_reading.crs->wkt() : std::string();
    std::vector<const char*> words{"-of",      "VRT",        "-ot", "Float64", "-r",
                                   "bilinear", "-dstnodata", "nan", "-t_srs",  to.c_str()};
    if (!from.empty())
        words.insert(words.end(), {"-s_srs", from.c_str()});
    words.push_back(nullptr);
    std::vector<char*> arguments;
    for (const char* word : words)
        arguments.push_back(const_cast<char*>(word));
    const std::unique_ptr<GDALWarpAppOptions, decltype(&GDALWarpAppOptionsFree)> options(
        GDALWarpAppOptionsNew(arguments.data(), nullptr), &GDALWarpAppOptionsFree);
    GDALDatasetH source = GDALDataset::ToHandle(m_source.get());
    int failed = 0;
    m_warped.reset(
        options ? GDALDataset::FromHandle(GDALWarp("", nullptr, 1, &source, options.get(), &failed))
                : nullptr);
    if (!m_warped)
        fail("cannot be warped to " + m_reading.warped_to->name() + ": " +
             geo::GdalErrorScope::reason());
    m_data = m_warped.get();
}

void HeightFile::learn() {
    m_band = m_data->GetRasterBand(1);
    if (m_data->GetRasterXSize() < 1 || m_data->GetRasterYSize() < 1)
        fail("a raster without cells");
    if (const std::string fault = fault_of_heights(*m_source); !fault.empty())
        fail(fault + "; an image is given with --ortho");
    m_keyed_unit = geo::vertical_unit_of_keys(geo::find_geokeys_of_tiff(path()));
    const bool is_known = m_keyed_unit.code == 0 || m_keyed_unit.metres ||
                          (*m_source->GetRasterBand(1)->GetUnitType() != '\0' &&
                           m_keyed_unit.code != geo::kUserDefinedKey);
    if (!is_known && !m_reading.height_unit_m)
        fail("unit of heights = " + std::to_string(m_keyed_unit.code) +
             " by its GeoTIFF keys; allowed: " + geo::kKeyedUnits +
             "; --world-vertical-unit (serve: --vertical-unit) says another one");
    // A file may declare one block of any size; GDAL would allocate the memory before it reads the
    // data.
    constexpr double kMaxBlock_bytes = 512e6;
    int block_x = 0;
    int block_y = 0;
    m_source->GetRasterBand(1)->GetBlockSize(&block_x, &block_y);
    if (static_cast<double>(block_x) * block_y * 8 > kMaxBlock_bytes)
        fail("its blocks are " + std::to_string(block_x) + " x " + std::to_string(block_y) +
             " cells; allowed: up to 512 MB; rewrite it with gdal_translate -co TILED=YES");
    if (m_data->GetGeoTransform(m_geo.data()) != CE_None)
        fail(m_data->GetGCPCount() > 0
                 ? "placed by control points alone; make it straight with gdalwarp"
                 : "not georeferenced (neither tags nor a world file)");
    const double area = m_geo[1] * m_geo[5] - m_geo[2] * m_geo[4];
    if (!std::all_of(m_geo.begin(), m_geo.end(), [](double v) { return std::isfinite(v); }) ||
        !(std::abs(area) > 0))
        fail("the size of its cells is not above 0 (area " + std::to_string(area) +
             "; allowed: above 0)");
    constexpr double kMaxAspect = 16;
    const double aspect = std::abs(m_geo[1] / m_geo[5]);
    if (north_up() && !(aspect <= kMaxAspect && aspect >= 1 / kMaxAspect))
        fail("its cells are " + std::to_string(aspect) +
             " times as wide as high; allowed: 1/16 to 16");
    if (m_reading.warped_to)
        m_crs = m_reading.warped_to;
    else if (m_reading.crs)
        m_crs = m_reading.crs;
    else if (const OGRSpatialReference* own = geo::Crs::placing(m_data->GetSpatialRef()))
        m_crs = geo::Crs::from_ogr(*own, path().string());
    else
        fail("no coordinate reference system; give one with --crs");
    if (const std::string fault = grid::fault_of_degrees(*m_crs, m_geo, m_data->GetRasterXSize(),
                                                         m_data->GetRasterYSize());
        !fault.empty())
        throw util::UsageError("read the heights of {}: {}, or --crs with the system that it is in",
                               path().string(), fault);
}

// A CRS given by the user is mostly horizontal only; the file's own may then define the unit of
// heights.
double HeightFile::vertical_unit_m() const {
    const OGRSpatialReference* own = geo::Crs::placing(m_source->GetSpatialRef());
    if (own == nullptr)
        return m_crs->vertical_metres_per_unit().value_or(1);
    try {
        return geo::Crs::from_ogr(*own, path().string()).vertical_metres_per_unit().value_or(1);
    } catch (const util::Error&) {
        if (!m_reading.crs)
            throw;
        return m_reading.crs->vertical_metres_per_unit().value_or(1);
    }
}

double HeightFile::stated_unit_m() const {
    const std::string written = m_source->GetRasterBand(1)->GetUnitType();
    const auto named = to_unit(written);
    if (!written.empty() && !named)
        fail("unit of heights = '" + written +
             "'; allowed: m, ft, US survey foot and equivalents; give it in metres");
    if (!m_keyed_unit.metres)
        return named ? *named : vertical_unit_m();
    // GDAL gives a band without a unit that of the vertical system's code, by its name at EPSG.
    const bool is_of_system = m_keyed_unit.has_system && (written == "metre" || written == "foot" ||
                                                          written == "US survey foot");
    constexpr double kSame = 1e-9;
    if (named && !is_of_system && std::abs(*named - *m_keyed_unit.metres) > kSame)
        fail("unit of heights = '" + written + "', but " + std::to_string(*m_keyed_unit.metres) +
             " m by its GeoTIFF keys; say which with --world-vertical-unit (serve: "
             "--vertical-unit)");
    return *m_keyed_unit.metres;
}

void HeightFile::learn_values() {
    GDALRasterBand* own = m_source->GetRasterBand(1);
    const double unit = m_reading.height_unit_m ? *m_reading.height_unit_m : stated_unit_m();
    int known = 0;
    const double scale = own->GetScale(&known);
    m_scale = known != 0 ? scale : 1;
    const double offset = own->GetOffset(&known);
    m_offset = known != 0 ? offset : 0;
    m_scale *= unit;
    m_offset *= unit;
    if (!std::isfinite(m_scale) || !std::isfinite(m_offset) || m_scale == 0)
        fail("scale of heights = " + std::to_string(m_scale) + "; allowed: a number that is not 0");
    const double nodata = m_band->GetNoDataValue(&known);
    if (known != 0 && !std::isnan(nodata))
        m_nodata = nodata;
    m_float_nodata = m_band->GetRasterDataType() == GDT_Float32;
    // Before it had a type of its own, GDAL read signed bytes as unsigned ones.
    const char* const kind = own->GetMetadataItem("PIXELTYPE", "IMAGE_STRUCTURE");
    m_signed_bytes = kind != nullptr && EQUAL(kind, "SIGNEDBYTE");
    if (m_signed_bytes && m_warped)
        fail("its values are signed bytes, and it must be warped; make it one of 16 bits");
    const int flags = m_band->GetMaskFlags();
    m_masked = (flags & (GMF_ALL_VALID | GMF_NODATA)) == 0;
}

std::string HeightFile::copyright() const {
    const char* text = m_source->GetMetadataItem("TIFFTAG_COPYRIGHT");
    return text != nullptr ? text : "";
}

HeightFile::Grid HeightFile::grid_for(double side) const noexcept {
    Grid out;
    out.width = m_data->GetRasterXSize();
    out.height = m_data->GetRasterYSize();
    out.x0 = m_geo[0];
    out.y0 = m_geo[3];
    out.dx = m_geo[1];
    out.dy = m_geo[5];
    const double span_x = out.dx * out.width;
    const double span_y = out.dy * out.height;
    // kMin: cells of an overview to a side, as they need not be aligned with the voxels.
    constexpr double kSlack = 1 + 1e-6;
    constexpr double kMin = 2;
    const auto fits = [&](double dx, double dy) {
        return std::max(std::abs(dx), std::abs(dy)) <= side * kSlack;
    };
    int finest = out.width;
    for (int i = 0; i < m_band->GetOverviewCount(); ++i) {
        GDALRasterBand* overview = m_band->GetOverview(i);
        if (overview == nullptr || overview->GetXSize() < 1 || overview->GetYSize() < 1 ||
            overview->GetXSize() >= finest)
            continue;
        if (!fits(kMin * span_x / overview->GetXSize(), kMin * span_y / overview->GetYSize()))
            continue;
        out.overview = i;
        finest = overview->GetXSize();
    }
    if (out.overview >= 0) {
        GDALRasterBand* overview = m_band->GetOverview(out.overview);
        out.width = overview->GetXSize();
        out.height = overview->GetYSize();
        out.dx = span_x / out.width;
        out.dy = span_y / out.height;
    }
    // Of many cells to a side, a subset: 8 to 16 are enough for a mean.
    constexpr int kEnough = 8;
    while (fits(out.dx * 2 * kEnough, out.dy * 2 * kEnough) && out.width >= 2 && out.height >= 2) {
        out.stride *= 2;
        out.width /= 2;
        out.height /= 2;
        out.dx *= 2;
        out.dy *= 2;
    }
    return out;
}

Cells HeightFile::read(const Grid& grid, int x, int y, int width, int height) {
    const geo::GdalErrorScope errors;
    Cells out;
    out.x = x;
    out.y = y;
    out.width = width;
    out.height = height;
    out.metres.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    GDALRasterBand* band = grid.overview >= 0 ? m_band->GetOverview(grid.overview) : m_band;
    const int s = grid.stride;
    const auto get = [&](GDALRasterBand* from, void* to, GDALDataType type) {
        if (from->RasterIO(GF_Read, x * s, y * s, width * s, height * s, to, width, height, type, 0,
                           0, nullptr) != CE_None)
            fail("damaged: " + geo::GdalErrorScope::reason());
    };
    get(band, out.metres.data(), GDT_Float64);
    if (m_signed_bytes)
        for (double& v : out.metres)
            v -= v > 127 ? 256 : 0;
    std::vector<std::uint8_t> mask;
    if (m_masked) {
        mask.resize(out.metres.size());
        get(band->GetMaskBand(), mask.data(), GDT_Byte);
        for (std::size_t i = 0; i < mask.size(); ++i)
            if (mask[i] < 128)
                out.metres[i] = kNone;  // of an alpha band: mostly transparent counts as none
    }
    to_metres(out.metres);
    return out;
}

void HeightFile::to_metres(std::vector<double>& values) const noexcept {
    // The nodata value of many files that do not declare one.
    constexpr double kUndeclared = -9999;
    const auto none = m_nodata ? static_cast<float>(*m_nodata) : 0.0F;
    for (double& v : values) {
        const bool nothing =
            v == kUndeclared ||
            (m_nodata && (v == *m_nodata || (m_float_nodata && static_cast<float>(v) == none)));
        v = nothing ? kNone : v * m_scale + m_offset;
        if (!(v >= kLowest_m && v <= kHighest_m))
            v = kNone;
    }
}

void HeightFile::extend(std::optional<Range>& range, const Grid& grid, int x, int y, int width,
                        int height) {
    for (const double v : read(grid, x, y, width, height).metres) {
        if (std::isnan(v))
            continue;
        if (!range)
            range = Range{v, v};
        range->low_m = std::min(range->low_m, v);
        range->high_m = std::max(range->high_m, v);
    }
}

// The finest overview, or the cells themselves, with at most max_cells cells.
std::optional<HeightFile::Grid> HeightFile::make_grid(double max_cells) const noexcept {
    Grid grid = grid_for(0);
    const double span_x = grid.dx * grid.width;
    const double span_y = grid.dy * grid.height;
    if (static_cast<double>(grid.width) * grid.height <= max_cells)
        return grid;
    double finest = 0;
    for (int i = 0; i < m_band->GetOverviewCount(); ++i) {
        GDALRasterBand* overview = m_band->GetOverview(i);
        const double cells = overview != nullptr
                                 ? static_cast<double>(overview->GetXSize()) * overview->GetYSize()
                                 : 0;
        if (cells <= finest || cells > max_cells)
            continue;
        finest = cells;
        grid.overview = i;
        grid.width = overview->GetXSize();
        grid.height = overview->GetYSize();
    }
    if (grid.overview < 0)
        return std::nullopt;
    grid.dx = span_x / grid.width;
    grid.dy = span_y / grid.height;
    return grid;
}

std::optional<HeightFile::Range> HeightFile::rough_range(double max_cells) {
    std::optional<Range> out;
    std::optional<util::Error> damage;
    const auto look = [&](const Grid& grid, int x, int y, int width, int height) {
        try {
            extend(out, grid, x, y, width, height);
        } catch (const util::Error& e) {
            damage = e;  // boxes that need it will fail; others will not
        }
    };
    const auto whole = make_grid(max_cells);
    constexpr int kRows = 256;
    if (whole)
        for (int y = 0; y < whole->height; y += kRows)
            look(*whole, 0, y, whole->width, std::min(kRows, whole->height - y));
    const bool exact = whole && whole->overview < 0;
    if (!out && !exact) {
        // A subset of its blocks, evenly spread.
        const Grid cells = grid_for(0);
        int block_x = 0;
        int block_y = 0;
        m_band->GetBlockSize(&block_x, &block_y);
        const std::int64_t across = (cells.width + block_x - 1) / block_x;
        const std::int64_t down = (cells.height + block_y - 1) / block_y;
        const std::int64_t blocks = across * down;
        const double max_blocks =
            std::max(max_cells / (static_cast<double>(block_x) * block_y), 4.0);
        const std::int64_t step =
            static_cast<std::int64_t>(static_cast<double>(blocks) / max_blocks) |
            1;  // odd: not always the same column of blocks
        for (std::int64_t i = 0; i < blocks; i += step) {
            const int x = static_cast<int>(i % across) * block_x;
            const int y = static_cast<int>(i / across) * block_y;
            look(cells, x, y, std::min(block_x, cells.width - x),
                 std::min(block_y, cells.height - y));
        }
    }
    if (!out && damage)
        throw util::Error(*damage);
    if (out)
        out->exact = exact && !damage;
    return out;
}

HeightFile::Outline HeightFile::outline() const noexcept {
    const double x = m_geo[0] + m_geo[1] * m_data->GetRasterXSize();
    const double y = m_geo[3] + m_geo[5] * m_data->GetRasterYSize();
    return {std::min(m_geo[0], x), std::min(m_geo[3], y), std::max(m_geo[0], x),
            std::max(m_geo[3], y)};
}

double HeightFile::cell_m() const noexcept {
    constexpr double kDegree_m = 111320;
    return std::max(std::hypot(m_geo[1], m_geo[4]), std::hypot(m_geo[2], m_geo[5])) *
           (m_crs->geographic() ? kDegree_m : m_crs->metres_per_unit());
}

}  // namespace terravox::heightmap
