#include "raytracer/analyse/raster/shadow_cube.hpp"

#include <algorithm>

#include "common/util/error.hpp"
#include "raytracer/analyse/raster/raster.hpp"

namespace terravox::analyse {
namespace {

constexpr int kBlock_px = 256;

}  // namespace

ShadowCube::ShadowCube(const std::filesystem::path& out, std::span<const std::string> names,
                       int columns, int rows)
    : m_attempt("write the raster " + out.string()),
      m_masks(names.size()),
      m_file(std::filesystem::path(out).replace_extension(".masks.tif")) {
    const output::GdalWatch watch(m_attempt);
    output::GdalOptions options = {{"TILED", "YES"},
                                   {"BLOCKXSIZE", std::to_string(kBlock_px)},
                                   {"BLOCKYSIZE", std::to_string(kBlock_px)},
                                   {"INTERLEAVE", "BAND"},
                                   {"PHOTOMETRIC", "MINISBLACK"},
                                   {"ALPHA", "UNSPECIFIED"},
                                   {"COMPRESS", "DEFLATE"},
                                   {"ZLEVEL", "1"},
                                   {"BIGTIFF", "YES"}};
    m_dataset.reset(GDALCreate(GDALGetDriverByName("GTiff"),
                               m_file.temporary_path().string().c_str(), columns, rows,
                               static_cast<int>(m_masks + 1), GDT_Byte, options.list()));
    watch.check(m_dataset != nullptr);
    for (std::size_t i = 0; i <= m_masks; ++i) {
        GDALRasterBandH band = GDALGetRasterBand(m_dataset.get(), static_cast<int>(i) + 1);
        GDALSetDescription(band, i < m_masks ? names[i].c_str() : "hole");
        watch.check(GDALSetRasterNoDataValue(band, kNoMask) == CE_None);
        // Else four bands of bytes would be the colours of a picture.
        watch.check(GDALSetRasterColorInterpretation(
                        band, i == 0 ? GCI_GrayIndex : GCI_Undefined) == CE_None);
    }
}

void ShadowCube::take(std::size_t index, CellFile& cells) {
    const int sunlit = band_number(core::AnalysisKind::kShadow, "sunlit");
    const int hole = band_number(core::AnalysisKind::kShadow, "hole");
    std::vector<float> lit;
    std::vector<float> missing;
    for (int y = 0; y < cells.rows(); y += kBlock_px)
        for (int x = 0; x < cells.columns(); x += kBlock_px) {
            const CellRectangle area{x, y, std::min(kBlock_px, cells.columns() - x),
                                     std::min(kBlock_px, cells.rows() - y)};
            cells.read(sunlit, area, lit);
            cells.read(hole, area, missing);
            std::vector<std::uint8_t> mask(lit.size());
            std::vector<std::uint8_t> holes =
                index == 0 ? std::vector<std::uint8_t>(lit.size()) : read_band(m_masks, area);
            for (std::size_t i = 0; i < lit.size(); ++i) {
                mask[i] = lit[i] > 0 ? 1 : 0;
                if (lit[i] == core::kNoData)
                    mask[i] = kNoMask;
                holes[i] = holes[i] != 0 || missing[i] > 0 ? 1 : 0;
            }
            write_band(index, area, mask);
            write_band(m_masks, area, holes);
        }
}

void ShadowCube::write_band(std::size_t index, const CellRectangle& area,
                            std::vector<std::uint8_t>& values) {
    const output::GdalWatch watch(m_attempt);
    watch.check(GDALRasterIOEx(GDALGetRasterBand(m_dataset.get(), static_cast<int>(index) + 1),
                               GF_Write, area.x0, area.y0, area.width, area.height, values.data(),
                               area.width, area.height, GDT_Byte, 0, 0, nullptr) == CE_None);
}

std::vector<std::uint8_t> ShadowCube::read_band(std::size_t index, const CellRectangle& area) {
    const output::GdalWatch watch(m_attempt);
    std::vector<std::uint8_t> out(static_cast<std::size_t>(area.width) *
                                  static_cast<std::size_t>(area.height));
    watch.check(GDALRasterIOEx(GDALGetRasterBand(m_dataset.get(), static_cast<int>(index) + 1),
                               GF_Read, area.x0, area.y0, area.width, area.height, out.data(),
                               area.width, area.height, GDT_Byte, 0, 0, nullptr) == CE_None);
    return out;
}

void ShadowCube::write(const std::filesystem::path& out, const output::PictureInfo& info,
                       int threads) {
    write_raster(m_dataset.get(), m_attempt, out, info, threads, false);
}

}  // namespace terravox::analyse
