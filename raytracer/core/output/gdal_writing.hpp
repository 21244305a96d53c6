#pragma once

#include <cpl_string.h>
#include <gdal.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "raytracer/core/output/picture.hpp"

namespace terravox::output {

/// Collects GDAL's errors on this thread during its lifetime, and keeps GDAL from writing files
/// next to the picture (.aux.xml).
class GdalWatch {
public:
    explicit GdalWatch(std::string attempt);
    ~GdalWatch();
    GdalWatch(const GdalWatch&) = delete;
    GdalWatch& operator=(const GdalWatch&) = delete;
    /// @throws Error "attempt: GDAL's message" when anything has failed, or when `done` is false
    void check(bool done) const;
    /// To be called after the last dataset of a TIFF file was closed.
    /// @throws Error as check(), and when the end of the file is missing
    void check_closed_tiff(const std::filesystem::path& file) const;
    [[nodiscard]] const std::string& attempt() const noexcept { return m_attempt; }

private:
    std::string m_attempt;
    std::string m_failure;
};

struct GdalClose {
    void operator()(GDALDatasetH dataset) const noexcept { GDALClose(dataset); }
};
using GdalDataset = std::unique_ptr<void, GdalClose>;

/// Names and values in the form that GDAL takes.
struct GdalOptions : CPLStringList {
    GdalOptions(std::initializer_list<std::pair<const char*, std::string>> options) {
        add(options);
    }
    void add(std::initializer_list<std::pair<const char*, std::string>> options) {
        for (const auto& [name, value] : options)
            AddNameValue(name, value.c_str());
    }
};

struct TiffLayout {
    int columns = 0;
    int rows = 0;
    int bands = 0;
    GDALDataType type = GDT_Byte;
    int block_columns = 0;
    int block_rows = 0;
};
/// Creates a compressed TIFF in blocks, larger than 4 GiB where need be.
/// @param options others than those
/// @throws Error
[[nodiscard]] GdalDataset create_tiff(const std::filesystem::path& file, const TiffLayout& layout,
                                      GdalOptions options, const GdalWatch& watch);

/// The name of a metadata item in GDAL, which would take what follows a colon for the value:
/// terravox_holes for terravox:holes.
[[nodiscard]] std::string gdal_name(std::string name);

/// Pixels that GDAL may read, the channels of each side by side: red, green, blue, perhaps alpha.
struct PixelsInMemory {
    const void* first = nullptr;
    GDALDataType type = GDT_Byte;
    int width_px = 0;
    int height_px = 0;
    int channels = 0;               ///< 3 or 4
    std::size_t channel_bytes = 0;  ///< from one channel of a pixel to the next
    std::size_t pixel_bytes = 0;    ///< from one pixel of a row to the next; rows have no gaps
};
/// @param samples width * height pixels of `channels` bytes; must outlive the result
[[nodiscard]] PixelsInMemory byte_pixels(const std::vector<std::uint8_t>& samples, int width_px,
                                         int height_px, int channels) noexcept;
/// Makes pixels accessible to GDAL without a copy.
/// @param pixels must outlive the dataset
/// @throws Error
[[nodiscard]] GdalDataset memory_dataset(const PixelsInMemory& pixels, const GdalWatch& watch);

/// Encodes a dataset as a file of some format, in memory: for small files, and where the writer of
/// the format does not report a full disk.
/// @return the bytes of the file
/// @throws Error
[[nodiscard]] std::string encode_in_memory(GDALDatasetH from, GDALDriverH driver,
                                           GdalOptions& options, const GdalWatch& watch);

/// Stores the georeference, if any, and the metadata, including the three names that TIFF has tags
/// for.
/// @throws Error for a CRS that cannot be read
void describe_geotiff(GDALDatasetH dataset, const PictureInfo& info, const GdalWatch& watch);

struct CogOptions {
    bool has_floats = false;
    int block_px = 512;
    std::string overview_resampling = "AVERAGE";  ///< GDAL's name
    std::string threads = "ALL_CPUS";             ///< for compression
    std::function<bool()> is_stopped;             ///< asked now and then; empty: never
};
/// Writes a copy of a dataset as a TIFF in tiles with overviews, laid out for reading by ranges
/// ("cloud optimized"); as plain tiles where GDAL lacks its COG driver.
/// @throws Error, also "interrupted"
void write_cog(GDALDatasetH from, const std::filesystem::path& file, const CogOptions& cog,
               const GdalWatch& watch);

}  // namespace terravox::output
