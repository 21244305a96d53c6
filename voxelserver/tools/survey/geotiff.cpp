#include "voxelserver/tools/survey/geotiff.hpp"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal_priv.h>
#include <ogr_spatialref.h>

#include "common/geo/crs.hpp"
#include "common/geo/gdal.hpp"
#include "common/geo/gdal_messages.hpp"
#include "common/geo/raster_gate.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"

namespace terravox::survey {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path) {
    throw util::Error("write " + path.string() + ": " + geo::GdalErrorScope::reason());
}

template <class Value>
void write(const std::filesystem::path& path, const SquareExtent& extent,
           const SquareRaster<Value>& raster, GDALDataType type, const char* predictor) {
    geo::start_gdal();
    geo::check_memory_for_gdal();
    util::AtomicFile file(path);
    const geo::GdalErrorScope errors;
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    if (driver == nullptr)
        fail(path);
    const char* const options[] = {"TILED=YES",        "BLOCKXSIZE=256", "BLOCKYSIZE=256",
                                   "COMPRESS=DEFLATE", "ZLEVEL=4",       predictor,
                                   "INTERLEAVE=PIXEL", nullptr};
    GDALDatasetUniquePtr image{driver->Create(file.temporary_path().c_str(), raster.side_px,
                                              raster.side_px, raster.bands, type,
                                              const_cast<char**>(options))};
    if (!image)
        fail(path);
    const double pixel_m = static_cast<double>(extent.size_m) / raster.side_px;
    double corner[6] = {static_cast<double>(extent.east_m),
                        pixel_m,
                        0,
                        static_cast<double>(extent.north_m + extent.size_m),
                        0,
                        -pixel_m};
    const geo::Crs crs = geo::Crs::from_text(kSurveyCrs);
    image->SetGeoTransform(corner);
    image->SetSpatialRef(&crs.ogr());
    const GSpacing pixel_bytes = static_cast<GSpacing>(sizeof(Value)) * raster.bands;
    if (image->RasterIO(GF_Write, 0, 0, raster.side_px, raster.side_px,
                        const_cast<Value*>(raster.pixels.data()), raster.side_px, raster.side_px,
                        type, raster.bands, nullptr, pixel_bytes, pixel_bytes * raster.side_px,
                        sizeof(Value), nullptr) != CE_None)
        fail(path);
    image.reset();  // flushes; a full disk is reported here
    if (CPLGetLastErrorType() >= CE_Failure)
        fail(path);
    const auto missing = geo::find_missing_part_of_tiff(file.temporary_path());
    if (missing)
        throw util::Error(
            "write " + path.string() +
            ": not all could be written (the disk may be full); missing: " + *missing);
    file.commit();
}

}  // namespace

void write_geotiff(const std::filesystem::path& path, const SquareExtent& extent,
                   const SquareRaster<std::uint8_t>& raster) {
    write(path, extent, raster, GDT_Byte, "PREDICTOR=2");
}

void write_geotiff(const std::filesystem::path& path, const SquareExtent& extent,
                   const SquareRaster<float>& raster) {
    write(path, extent, raster, GDT_Float32, "PREDICTOR=3");
}

std::string survey_wkt1() {
    const geo::Crs crs = geo::Crs::from_text(kSurveyCrs);
    char* text = nullptr;
    const char* const options[] = {"FORMAT=WKT1_GDAL", "MULTILINE=NO", nullptr};
    const geo::GdalErrorScope errors;
    if (crs.ogr().exportToWkt(&text, options) != OGRERR_NONE)
        throw util::Error(std::string("describe ") + kSurveyCrs + " as WKT 1: GDAL failed");
    std::string wkt = text;
    CPLFree(text);
    return wkt;
}

}  // namespace terravox::survey
