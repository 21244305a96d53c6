#include "raytracer/analyse/raster/shadow_cube.hpp"

#include <gdal_utils.h>
#include <memory>
#include <utility>

#include "common/geo/gdal_files.hpp"
#include "common/util/atomic_file.hpp"
#include "common/util/text.hpp"

namespace terravox::analyse {
namespace {

struct OptionsFree {
    void operator()(GDALTranslateOptions* options) const noexcept {
        GDALTranslateOptionsFree(options);
    }
};

/// A dataset without a file that has the first bands of another one, and none of its texts.
output::GdalDataset first_bands(GDALDatasetH from, std::size_t count,
                                const output::GdalWatch& watch) {
    std::vector<std::string> words = {"-of", "VRT"};
    for (std::size_t band = 1; band <= count; ++band)
        words.insert(words.end(), {"-b", std::to_string(band)});
    std::vector<char*> pointers;
    for (std::string& word : words)
        pointers.push_back(word.data());
    pointers.push_back(nullptr);
    const std::unique_ptr<GDALTranslateOptions, OptionsFree> options(
        GDALTranslateOptionsNew(pointers.data(), nullptr));
    output::GdalDataset out(GDALTranslate("", from, options.get(), nullptr));
    watch.check(out != nullptr);
    GDALSetMetadata(out.get(), nullptr, nullptr);
    return out;
}

/// The attribute of CF or ACDD for a text of a picture; nullptr: none.
const char* find_attribute(const std::string& name) noexcept {
    if (name == "ImageDescription")
        return "title";
    if (name == "Software")
        return "source";
    return name == "Copyright" ? "license" : nullptr;
}

/// Numbers as GDAL's driver for netCDF reads them: {1,2}.
std::string to_list(std::span<const std::int64_t> numbers) {
    std::string out;
    for (const std::int64_t number : numbers)
        out += (out.empty() ? "{" : ",") + std::to_string(number);
    return out + "}";
}

}  // namespace

void write_netcdf(GDALDatasetH bands, const std::string& attempt, const CubeVariable& variable,
                  std::span<const std::int64_t> times_s, const std::filesystem::path& out,
                  const output::PictureInfo& info) {
    const output::GdalWatch watch(attempt);
    output::describe_geotiff(bands, info, watch);
    const output::GdalDataset cube = first_bands(bands, times_s.size(), watch);
    const auto note = [&](const std::string& name, const std::string& value) {
        GDALSetMetadataItem(cube.get(), name.c_str(), value.c_str(), nullptr);
    };
    constexpr int kDouble = 6;  // NC_DOUBLE, which every reader of times takes
    note("NETCDF_DIM_EXTRA", "{time}");
    note("NETCDF_DIM_time_DEF",
         "{" + std::to_string(times_s.size()) + "," + std::to_string(kDouble) + "}");
    note("NETCDF_DIM_time_VALUES", to_list(times_s));
    note("time#units", "seconds since 1970-01-01 00:00:00");
    note("time#calendar", "standard");
    note("time#standard_name", "time");
    note("time#axis", "T");
    for (const auto& [name, value] : info.metadata)
        if (const char* const attribute = find_attribute(name); attribute != nullptr)
            note(std::string("NC_GLOBAL#") + attribute, value);
    GDALRasterBandH first = GDALGetRasterBand(cube.get(), 1);
    GDALSetMetadataItem(first, "NETCDF_VARNAME", variable.name, nullptr);
    GDALSetMetadataItem(first, "long_name", variable.long_name, nullptr);
    util::AtomicFile target(out);
    output::GdalOptions options = {
        {"FORMAT", "NC4C"}, {"COMPRESS", "DEFLATE"}, {"WRITE_GDAL_HISTORY", "NO"}};
    output::GdalDataset copy(GDALCreateCopy(geo::netcdf_driver(),
                                            target.temporary_path().string().c_str(), cube.get(),
                                            FALSE, options.List(), nullptr, nullptr));
    watch.check(copy != nullptr);
    copy.reset();  // writes what is left
    watch.check(true);
    target.commit();
}

namespace {

constexpr int kBlock_px = 256;

}  // namespace

void ShadowCube::check_target(const std::filesystem::path& out) {
    if (!is_netcdf(out)) {
        check_raster_target(out);
        return;
    }
    util::check_writable(out);
    (void)geo::netcdf_driver();
}

ShadowCube::ShadowCube(const std::filesystem::path& out, std::vector<Mask> masks, int columns,
                       int rows)
    : m_attempt("write the raster " + out.string()),
      m_masks(std::move(masks)),
      m_file(std::filesystem::path(out).replace_extension(".masks.tif")) {
    const output::GdalWatch watch(m_attempt);
    m_dataset = output::create_tiff(
        m_file.temporary_path(),
        {columns, rows, static_cast<int>(m_masks.size() + 1), GDT_Byte, kBlock_px, kBlock_px},
        {{"INTERLEAVE", "BAND"},
         {"PHOTOMETRIC", "MINISBLACK"},
         {"ALPHA", "UNSPECIFIED"},
         {"ZLEVEL", "1"}},
        watch);
    for (std::size_t i = 0; i <= m_masks.size(); ++i) {
        GDALRasterBandH band = GDALGetRasterBand(m_dataset.get(), static_cast<int>(i) + 1);
        GDALSetDescription(band, i < m_masks.size() ? m_masks[i].name.c_str() : "hole");
        watch.check(GDALSetRasterNoDataValue(band, kNoMask) == CE_None);
        // Else four bands of bytes would be the colours of a picture.
        watch.check(GDALSetRasterColorInterpretation(
                        band, i == 0 ? GCI_GrayIndex : GCI_Undefined) == CE_None);
    }
}

void ShadowCube::take(std::size_t index, CellFile& cells) {
    std::vector<float> lit;
    std::vector<float> missing;
    cells.each_block(kBlock_px, [&](const CellRectangle& area) {
        cells.read("sunlit", area, lit);
        cells.read("hole", area, missing);
        std::vector<std::uint8_t> mask(lit.size());
        std::vector<std::uint8_t> holes =
            index == 0 ? std::vector<std::uint8_t>(lit.size()) : read_band(m_masks.size(), area);
        for (std::size_t i = 0; i < lit.size(); ++i) {
            mask[i] = lit[i] > 0 ? 1 : 0;
            if (lit[i] == core::kNoData)
                mask[i] = kNoMask;
            holes[i] = holes[i] != 0 || missing[i] > 0 ? 1 : 0;
        }
        write_band(index, area, mask);
        write_band(m_masks.size(), area, holes);
    });
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
    if (!is_netcdf(out)) {
        write_raster(m_dataset.get(), m_attempt, out, info, threads, false);
        return;
    }
    std::vector<std::int64_t> times_s;
    for (const Mask& mask : m_masks)
        times_s.push_back(mask.time_s);
    GDALFlushCache(m_dataset.get());
    write_netcdf(m_dataset.get(), m_attempt, {"sunlit", "1: direct sun, 0: shadow"}, times_s, out,
                 info);
}

}  // namespace terravox::analyse
