#include "common/geo/whole_tiff.hpp"

#include <gdal_priv.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>

#include "common/geo/quiet_gdal.hpp"

namespace terravox::geo {
namespace {

/// One number of those that GDAL tells of a block; 0 for what was never written.
std::uint64_t number_of(GDALRasterBand& band, const char* what, int column, int row) {
    const std::string name = what + std::to_string(column) + "_" + std::to_string(row);
    const char* text = band.GetMetadataItem(name.c_str(), "TIFF");
    return text == nullptr ? 0 : std::strtoull(text, nullptr, 10);
}

/// The first byte behind the last block of a directory.
std::uint64_t end_of_blocks(GDALRasterBand& band) {
    int width_px = 0;
    int height_px = 0;
    band.GetBlockSize(&width_px, &height_px);
    if (width_px <= 0 || height_px <= 0) return 0;
    const int columns = (band.GetXSize() + width_px - 1) / width_px;
    const int rows = (band.GetYSize() + height_px - 1) / height_px;
    std::uint64_t end = 0;
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column) {
            const std::uint64_t first = number_of(band, "BLOCK_OFFSET_", column, row);
            const std::uint64_t bytes = number_of(band, "BLOCK_SIZE_", column, row);
            end = std::max(end, first + bytes);
        }
    }
    return end;
}

}  // namespace

std::optional<std::string> missing_of_tiff(const std::filesystem::path& file) {
    const QuietGdal quiet;
    const char* const drivers[] = {"GTiff", nullptr};
    const GDALDatasetUniquePtr image{GDALDataset::Open(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, drivers)};
    if (!image) return "its directory: " + QuietGdal::reason();
    std::uint64_t end = 0;
    for (GDALRasterBand* band : image->GetBands()) {
        end = std::max(end, end_of_blocks(*band));
        for (int i = 0; i < band->GetOverviewCount(); ++i) {
            GDALRasterBand* overview = band->GetOverview(i);
            if (overview == nullptr) return "an overview";
            end = std::max(end, end_of_blocks(*overview));
        }
    }
    const std::uint64_t there = std::filesystem::file_size(file);
    if (end <= there) return std::nullopt;
    return std::to_string(end - there) + " of " + std::to_string(end) + " bytes";
}

}  // namespace terravox::geo
