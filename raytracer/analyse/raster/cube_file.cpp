#include "raytracer/analyse/raster/cube_file.hpp"

#include <gdal_utils.h>

#include <memory>
#include <vector>

#include "common/geo/writing_drivers.hpp"
#include "common/util/atomic_file.hpp"

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
const char* attribute_of(const std::string& name) noexcept {
    if (name == "ImageDescription")
        return "title";
    if (name == "Software")
        return "source";
    return name == "Copyright" ? "license" : nullptr;
}

/// Numbers as GDAL's driver for netCDF reads them: {1,2}.
std::string list_of(std::span<const std::int64_t> numbers) {
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
    note("NETCDF_DIM_time_VALUES", list_of(times_s));
    note("time#units", "seconds since 1970-01-01 00:00:00");
    note("time#calendar", "standard");
    note("time#standard_name", "time");
    note("time#axis", "T");
    for (const auto& [name, value] : info.metadata)
        if (const char* const attribute = attribute_of(name); attribute != nullptr)
            note(std::string("NC_GLOBAL#") + attribute, value);
    GDALRasterBandH first = GDALGetRasterBand(cube.get(), 1);
    GDALSetMetadataItem(first, "NETCDF_VARNAME", variable.name, nullptr);
    GDALSetMetadataItem(first, "long_name", variable.long_name, nullptr);
    util::AtomicFile target(out);
    output::GdalOptions options = {
        {"FORMAT", "NC4C"}, {"COMPRESS", "DEFLATE"}, {"WRITE_GDAL_HISTORY", "NO"}};
    output::GdalDataset copy(GDALCreateCopy(geo::netcdf_driver(),
                                            target.temporary_path().string().c_str(), cube.get(),
                                            FALSE, options.list(), nullptr, nullptr));
    watch.check(copy != nullptr);
    copy.reset();  // writes what is left
    watch.check(true);
    target.commit();
}

}  // namespace terravox::analyse
