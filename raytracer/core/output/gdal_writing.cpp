#include "raytracer/core/output/gdal_writing.hpp"

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_vsi.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <atomic>

#include "common/geo/crs.hpp"
#include "common/geo/gdal.hpp"
#include "common/geo/gdal_messages.hpp"
#include "common/geo/raster_gate.hpp"
#include "common/util/error.hpp"

namespace terravox::output {
namespace {

void CPL_STDCALL remember(CPLErr kind, CPLErrorNum number, const char* said) noexcept {
    geo::end_program_if_fatal(kind, number, said);
    auto* failure = static_cast<std::string*>(CPLGetErrorHandlerUserData());
    if (kind < CE_Failure || failure == nullptr || !failure->empty())
        return;
    *failure = said != nullptr && *said != '\0' ? said : "GDAL failed and did not say why";
    for (char& c : *failure)
        if (c == '\n' || c == '\r')
            c = ' ';
}

/// The name of a file in the memory of GDAL, which ends with this object.
class MemoryFile {
public:
    MemoryFile() {
        static std::atomic<std::uint64_t> count = 0;
        m_name = "/vsimem/terravox-" + std::to_string(++count);
    }
    ~MemoryFile() { VSIUnlink(m_name.c_str()); }
    MemoryFile(const MemoryFile&) = delete;
    MemoryFile& operator=(const MemoryFile&) = delete;
    [[nodiscard]] const char* name() const noexcept { return m_name.c_str(); }

private:
    std::string m_name;
};

const char* find_tag(const std::string& name) noexcept {
    return name == "Software"           ? "TIFFTAG_SOFTWARE"
           : name == "Copyright"        ? "TIFFTAG_COPYRIGHT"
           : name == "ImageDescription" ? "TIFFTAG_IMAGEDESCRIPTION"
                                        : nullptr;
}

/// A progress function of GDAL's.
/// @param is_stopped a std::function<bool()>, which may be empty
int CPL_STDCALL go_on(double, const char*, void* is_stopped) noexcept {
    const auto& asked = *static_cast<const std::function<bool()>*>(is_stopped);
    return asked && asked() ? FALSE : TRUE;
}

geo::Crs parse_crs(const std::string& wkt, const GdalWatch& watch) {
    try {
        return geo::Crs::from_wkt(wkt);
    } catch (const util::Error& e) {
        throw util::Error(watch.attempt() + ": " + e.what());
    }
}

}  // namespace

GdalWatch::GdalWatch(std::string attempt) : m_attempt(std::move(attempt)) {
    geo::start_gdal();
    geo::check_memory_for_gdal();
    CPLSetThreadLocalConfigOption("GDAL_PAM_ENABLED", "NO");
    CPLPushErrorHandlerEx(remember, &m_failure);
}

GdalWatch::~GdalWatch() {
    CPLPopErrorHandler();
    geo::forget_missing_memory();
    CPLSetThreadLocalConfigOption("GDAL_PAM_ENABLED", nullptr);
}

void GdalWatch::check(bool done) const {
    if (!m_failure.empty())
        throw util::Error(m_attempt + ": " + m_failure);
    if (!done)
        throw util::Error(m_attempt + ": GDAL failed and did not say why");
}

void GdalWatch::check_closed_tiff(const std::filesystem::path& file) const {
    check(true);
    const auto missing = geo::find_missing_part_of_tiff(file);
    if (missing)
        throw util::Error(
            m_attempt + ": not all could be written (the disk may be full); missing: " + *missing);
}

GdalDataset create_tiff(const std::filesystem::path& file, const TiffLayout& layout,
                        GdalOptions options, const GdalWatch& watch) {
    options.add({{"TILED", "YES"},
                 {"BLOCKXSIZE", std::to_string(layout.block_columns)},
                 {"BLOCKYSIZE", std::to_string(layout.block_rows)},
                 {"COMPRESS", "DEFLATE"},
                 {"BIGTIFF", "YES"}});
    GdalDataset out(GDALCreate(GDALGetDriverByName("GTiff"), file.string().c_str(), layout.columns,
                               layout.rows, layout.bands, layout.type, options.List()));
    watch.check(out != nullptr);
    return out;
}

PixelsInMemory byte_pixels(const std::vector<std::uint8_t>& samples, int width_px, int height_px,
                           int channels) noexcept {
    return {samples.data(),
            GDT_Byte,
            width_px,
            height_px,
            channels,
            1,
            static_cast<std::size_t>(channels)};
}

GdalDataset memory_dataset(const PixelsInMemory& pixels, const GdalWatch& watch) {
    constexpr std::array kMeaning = {GCI_RedBand, GCI_GreenBand, GCI_BlueBand, GCI_AlphaBand};
    GdalDataset out(GDALCreate(GDALGetDriverByName("MEM"), "", pixels.width_px, pixels.height_px, 0,
                               GDT_Byte, nullptr));
    watch.check(out != nullptr);
    const std::size_t row_bytes = static_cast<std::size_t>(pixels.width_px) * pixels.pixel_bytes;
    const auto* first = static_cast<const std::byte*>(pixels.first);
    for (int channel = 0; channel < pixels.channels; ++channel) {
        const auto i = static_cast<std::size_t>(channel);
        GdalOptions options = {
            {"DATAPOINTER",
             fmt::format("{}", static_cast<const void*>(first + i * pixels.channel_bytes))},
            {"PIXELOFFSET", std::to_string(pixels.pixel_bytes)},
            {"LINEOFFSET", std::to_string(row_bytes)}};
        watch.check(GDALAddBand(out.get(), pixels.type, options.List()) == CE_None);
        GDALSetRasterColorInterpretation(GDALGetRasterBand(out.get(), channel + 1), kMeaning[i]);
    }
    return out;
}

std::string encode_in_memory(GDALDatasetH from, GDALDriverH driver, GdalOptions& options,
                             const GdalWatch& watch) {
    const MemoryFile memory;
    GdalDataset file(
        GDALCreateCopy(driver, memory.name(), from, FALSE, options.List(), nullptr, nullptr));
    watch.check(file != nullptr);
    file.reset();  // writes what is left
    vsi_l_offset bytes = 0;
    const GByte* const encoded = VSIGetMemFileBuffer(memory.name(), &bytes, FALSE);
    watch.check(encoded != nullptr);
    return {reinterpret_cast<const char*>(encoded), bytes};
}

void describe_geotiff(GDALDatasetH dataset, const PictureInfo& info, const GdalWatch& watch) {
    if (info.geo) {
        std::array<double, 6> transform = info.geo->transform;
        watch.check(GDALSetGeoTransform(dataset, transform.data()) == CE_None);
        if (!info.geo->crs_wkt.empty()) {
            const geo::Crs crs = parse_crs(info.geo->crs_wkt, watch);
            watch.check(GDALSetSpatialRef(
                            dataset, OGRSpatialReference::ToHandle(
                                         const_cast<OGRSpatialReference*>(&crs.ogr()))) == CE_None);
        }
        GDALSetMetadataItem(dataset, "AREA_OR_POINT", "Area", nullptr);
    }
    for (const auto& [name, value] : info.metadata) {
        const char* tag = find_tag(name);
        GDALSetMetadataItem(dataset, tag != nullptr ? tag : gdal_name(name).c_str(), value.c_str(),
                            nullptr);
    }
}

void write_cog(GDALDatasetH from, const std::filesystem::path& file, const CogOptions& cog,
               const GdalWatch& watch) {
    const std::string predictor = cog.has_floats ? "3" : "2";
    const std::string edge = std::to_string(cog.block_px);
    GDALDriverH driver = GDALGetDriverByName("COG");
    GdalOptions options = {{"COMPRESS", "DEFLATE"},
                           {"PREDICTOR", predictor},
                           {"BIGTIFF", "IF_SAFER"},
                           {"NUM_THREADS", cog.threads}};
    if (driver != nullptr) {
        options.add({{"BLOCKSIZE", edge}, {"OVERVIEW_RESAMPLING", cog.overview_resampling}});
    } else {
        driver = GDALGetDriverByName("GTiff");
        options.add({{"TILED", "YES"}, {"BLOCKXSIZE", edge}, {"BLOCKYSIZE", edge}});
    }
    GdalDataset out(GDALCreateCopy(driver, file.string().c_str(), from, FALSE, options.List(),
                                   go_on, const_cast<std::function<bool()>*>(&cog.is_stopped)));
    if (!out && cog.is_stopped && cog.is_stopped())
        throw util::Error(watch.attempt() + ": interrupted");
    watch.check(out != nullptr);
    out.reset();  // writes what is left
    watch.check_closed_tiff(file);
}

std::string gdal_name(std::string name) {
    std::replace_if(name.begin(), name.end(), [](char c) { return c == ':' || c == '='; }, '_');
    return name;
}

}  // namespace terravox::output
