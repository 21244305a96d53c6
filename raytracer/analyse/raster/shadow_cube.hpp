#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "common/util/text.hpp"
#include "raytracer/analyse/raster/cell_file.hpp"
#include "raytracer/core/output/gdal_writing.hpp"
#include "raytracer/core/output/picture.hpp"

namespace terravox::analyse {

/// A variable of a file with a dimension of time.
struct CubeVariable {
    const char* name;
    const char* long_name;
};

/// Writes the first bands of a dataset as a netCDF file (CF conventions, netCDF-4, compressed): one
/// variable by time, y and x.
/// @param bands georeferenced, of one type, with a value for no data
/// @param times_s seconds since 1970-01-01 00:00 UTC of the first bands, rising
/// @param info its texts of source and licence become attributes
/// @throws Error
void write_netcdf(GDALDatasetH bands, const std::string& attempt, const CubeVariable& variable,
                  std::span<const std::int64_t> times_s, const std::filesystem::path& out,
                  const output::PictureInfo& info);

/// Shadow masks of several instants in a temporary file next to the output: a band of bytes for
/// each, and one that counts holes. The file is removed with the object. Not thread-safe.
class ShadowCube {
public:
    static constexpr std::uint8_t kNoMask = 255;  ///< no value: outside of the data, behind a hole

    /// An instant and the name of its band.
    struct Mask {
        std::string name;
        std::int64_t time_s = 0;  ///< seconds since 1970-01-01 00:00 UTC
    };
    /// @param masks of netCDF in the order of time
    /// @throws Error when it cannot be written
    ShadowCube(const std::filesystem::path& out, std::vector<Mask> masks, int columns, int rows);

    /// Whether a file is to be netCDF: by its ending.
    [[nodiscard]] static bool is_netcdf(const std::filesystem::path& out) {
        return util::lower_extension(out) == ".nc";
    }
    /// Rejects what cannot be written.
    /// @throws UsageError, Error
    static void check_target(const std::filesystem::path& out);

    /// Takes the mask of an instant.
    /// @param index of its instant
    /// @param cells of AnalysisKind::kShadow, as many as this has @throws Error
    void take(std::size_t index, CellFile& cells);
    /// Writes the masks as a Cloud Optimized GeoTIFF with the band of holes, or as a variable of
    /// netCDF by time.
    /// @throws Error
    void write(const std::filesystem::path& out, const output::PictureInfo& info, int threads);

private:
    void write_band(std::size_t index, const CellRectangle& area,
                    std::vector<std::uint8_t>& values);
    [[nodiscard]] std::vector<std::uint8_t> read_band(std::size_t index, const CellRectangle& area);

    const std::string m_attempt;
    const std::vector<Mask> m_masks;
    util::AtomicFile m_file;  // outlives the dataset in it; never committed
    output::GdalDataset m_dataset;
};

}  // namespace terravox::analyse
