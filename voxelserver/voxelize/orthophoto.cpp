#include "voxelserver/voxelize/orthophoto.hpp"

#include <gdal_priv.h>
#include <gdalwarper.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <mutex>

#include "common/util/error.hpp"
#include "common/util/files.hpp"

namespace terravox::voxelize {

namespace fs = std::filesystem;

/// One image, opened when first needed. North-up in the frame's CRS after an optional warp.
class Orthophotos::Image {
public:
    Image(const fs::path& path, const Frame& frame) : m_path(path) {
        CPLPushErrorHandler(CPLQuietErrorHandler);
        m_source.reset(GDALDataset::Open(path.string().c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY));
        const std::string reason = CPLGetLastErrorMsg();
        CPLPopErrorHandler();
        if (!m_source) fail(fs::exists(path) ? "no image that GDAL can read" : "no such file");
        if (m_source->GetRasterCount() < 1 || m_source->GetRasterXSize() < 1) fail("an image without pixels");
        m_image = m_source.get();
        if (m_image->GetGeoTransform(m_geo.data()) != CE_None) fail("no place on Earth (neither GeoTIFF tags nor a world file)");
        const OGRSpatialReference* own = m_image->GetSpatialRef();
        const bool north_up = m_geo[2] == 0 && m_geo[4] == 0 && m_geo[1] > 0 && m_geo[5] < 0;
        const bool same = own == nullptr || geo::Crs::from_ogr(*own).same_horizontal(frame.crs());
        if (own == nullptr) spdlog::info("orthophoto {}: no CRS in the file; taken to be in {}", path.string(), frame.crs().name());
        if (!same || !north_up) warp(frame, own);
        m_bands = std::min(m_source->GetRasterCount(), 3);
        GDALRasterBand* first = m_source->GetRasterBand(1);
        m_palette = first->GetColorTable();
        m_wide = first->GetRasterDataType() != GDT_Byte;
    }

    void read(const Frame& frame, std::int32_t x0, std::int32_t z0, PatchColours& out) const {
        // Columns whose centre lies in the image, as a rectangle [c0, c1) x [r0, r1) of the patch.
        const double px = frame.units_per_voxel() / m_geo[1], py = frame.units_per_voxel() / -m_geo[5];  // pixels per voxel
        const double left = (frame.easting(x0) - m_geo[0]) / m_geo[1], top = (frame.northing(z0) - m_geo[3]) / m_geo[5];
        const auto first = [](double offset, double step) { return std::clamp(static_cast<int>(std::ceil(-offset / step - 0.5)), 0, kPatchSize); };
        const auto last = [](double offset, double step, int size) { return std::clamp(static_cast<int>(std::ceil((size - offset) / step - 0.5)), 0, kPatchSize); };
        const int c0 = first(left, px), c1 = last(left, px, m_image->GetRasterXSize());
        const int r0 = first(top, py), r1 = last(top, py, m_image->GetRasterYSize());
        if (c0 >= c1 || r0 >= r1) return;
        const int columns = c1 - c0, rows = r1 - r0;
        const double wx = std::max(0.0, left + c0 * px), wy = std::max(0.0, top + r0 * py);
        const double ww = std::min(columns * px, m_image->GetRasterXSize() - wx), wh = std::min(rows * py, m_image->GetRasterYSize() - wy);
        const auto pixels = static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows);
        std::array<std::vector<std::uint16_t>, 3> bands;
        for (int b = 0; b < m_bands; ++b) {
            bands[static_cast<std::size_t>(b)].resize(pixels);
            read_band(m_image->GetRasterBand(b + 1), wx, wy, ww, wh, columns, rows, bands[static_cast<std::size_t>(b)].data(), m_palette == nullptr);
        }
        std::vector<std::uint16_t> mask(pixels);
        read_band(m_image->GetRasterBand(1)->GetMaskBand(), wx, wy, ww, wh, columns, rows, mask.data(), false);
        if (out.valid.empty()) out.valid.assign(kPatchSize * kPatchSize, 0), out.colour.resize(kPatchSize * kPatchSize);
        for (int r = 0; r < rows; ++r)
            for (int c = 0; c < columns; ++c) {
                const auto from = static_cast<std::size_t>(r * columns + c), to = static_cast<std::size_t>((r0 + r) * kPatchSize + c0 + c);
                if (out.valid[to] != 0 || mask[from] == 0) continue;
                out.colour[to] = colour_of(bands, from);
                out.valid[to] = 1;
            }
    }

private:
    [[noreturn]] void fail(const std::string& what) const { throw Error("read the orthophoto " + m_path.string() + ": " + what); }

    void warp(const Frame& frame, const OGRSpatialReference* own) {
        char* from = nullptr;
        char* to = nullptr;
        if (own != nullptr) own->exportToWkt(&from);
        OGRSpatialReference flat(frame.crs().ogr());
        flat.StripVertical();
        flat.exportToWkt(&to);
        // An alpha band of its own: the corners around a turned image are no colour, not black.
        const int bands = m_source->GetRasterCount();
        const bool own_alpha = m_source->GetRasterBand(bands)->GetColorInterpretation() == GCI_AlphaBand;
        const bool palette = m_source->GetRasterBand(1)->GetColorTable() != nullptr;
        GDALWarpOptions* options = GDALCreateWarpOptions();
        options->nBandCount = own_alpha ? bands - 1 : bands;
        options->nSrcAlphaBand = own_alpha ? bands : 0;
        options->nDstAlphaBand = options->nBandCount + 1;
        options->panSrcBands = static_cast<int*>(CPLMalloc(sizeof(int) * static_cast<std::size_t>(options->nBandCount)));
        options->panDstBands = static_cast<int*>(CPLMalloc(sizeof(int) * static_cast<std::size_t>(options->nBandCount)));
        for (int b = 0; b < options->nBandCount; ++b) options->panSrcBands[b] = options->panDstBands[b] = b + 1;
        int has_nodata = 0;
        const double nodata = m_source->GetRasterBand(1)->GetNoDataValue(&has_nodata);
        if (has_nodata != 0) GDALWarpInitSrcNoDataReal(options, nodata);
        CPLPushErrorHandler(CPLQuietErrorHandler);
        constexpr double kError_px = 0.125;
        m_warped.reset(static_cast<GDALDataset*>(GDALAutoCreateWarpedVRT(m_source.get(), from != nullptr ? from : to, to,
                                                                         palette ? GRA_NearestNeighbour : GRA_Bilinear, kError_px, options)));
        CPLPopErrorHandler();
        GDALDestroyWarpOptions(options);
        CPLFree(from), CPLFree(to);
        if (!m_warped) fail("cannot be transformed to " + frame.crs().name() + ": " + CPLGetLastErrorMsg());
        m_image = m_warped.get();
        m_image->GetGeoTransform(m_geo.data());
    }

    void read_band(GDALRasterBand* band, double wx, double wy, double ww, double wh, int columns, int rows, std::uint16_t* into, bool mean) const {
        GDALRasterIOExtraArg extra;
        INIT_RASTERIO_EXTRA_ARG(extra);
        extra.bFloatingPointWindowValidity = TRUE;
        extra.dfXOff = wx, extra.dfYOff = wy, extra.dfXSize = ww, extra.dfYSize = wh;
        extra.eResampleAlg = !mean ? GRIORA_NearestNeighbour : ww > columns ? GRIORA_Average : GRIORA_Bilinear;
        const int ix = static_cast<int>(wx), iy = static_cast<int>(wy);
        const int iw = std::min(static_cast<int>(std::ceil(wx + ww)), band->GetXSize()) - ix, ih = std::min(static_cast<int>(std::ceil(wy + wh)), band->GetYSize()) - iy;
        CPLPushErrorHandler(CPLQuietErrorHandler);
        const CPLErr failed = band->RasterIO(GF_Read, ix, iy, std::max(iw, 1), std::max(ih, 1), into, columns, rows, GDT_UInt16, 0, 0, &extra);
        CPLPopErrorHandler();
        if (failed != CE_None) fail(std::string("damaged: ") + CPLGetLastErrorMsg());
    }

    [[nodiscard]] voxel::Rgb8 colour_of(const std::array<std::vector<std::uint16_t>, 3>& bands, std::size_t i) const {
        const auto to8 = [&](std::uint16_t v) { return static_cast<std::uint8_t>(m_wide ? v >> 8 : std::min<int>(v, 255)); };
        if (m_palette != nullptr) {
            const GDALColorEntry* entry = m_palette->GetColorEntry(bands[0][i]);
            if (entry == nullptr) return {};
            return {static_cast<std::uint8_t>(entry->c1), static_cast<std::uint8_t>(entry->c2), static_cast<std::uint8_t>(entry->c3)};
        }
        if (m_bands < 3) return {to8(bands[0][i]), to8(bands[0][i]), to8(bands[0][i])};
        return {to8(bands[0][i]), to8(bands[1][i]), to8(bands[2][i])};
    }

    fs::path m_path;
    GDALDatasetUniquePtr m_source, m_warped;
    GDALDataset* m_image = nullptr;
    std::array<double, 6> m_geo{};
    int m_bands = 1;
    const GDALColorTable* m_palette = nullptr;
    bool m_wide = false;
};

namespace {

std::mutex& gdal_mutex() {
    static std::mutex mutex;
    return mutex;
}

}  // namespace

Orthophotos::Orthophotos(const std::vector<fs::path>& paths, const Frame& frame) : m_frame(frame) {
    static std::once_flag once;
    std::call_once(once, [] { GDALAllRegister(); });
    for (const fs::path& file : util::expand_folders(paths, {".tif", ".tiff", ".vrt", ".jp2", ".jpg", ".jpeg", ".png"}, "orthophotos")) m_images.push_back(std::make_unique<Image>(file, frame));
}

Orthophotos::~Orthophotos() = default;

std::size_t Orthophotos::count() const noexcept { return m_images.size(); }

PatchColours Orthophotos::colours(std::int32_t x0, std::int32_t z0) const {
    // GDAL data sets are not thread-safe.
    const std::lock_guard lock(gdal_mutex());
    PatchColours out;
    for (const auto& image : m_images) image->read(m_frame, x0, z0, out);
    return out;
}

}  // namespace terravox::voxelize
