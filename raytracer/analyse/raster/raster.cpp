#include "raytracer/analyse/raster/raster.hpp"

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "common/util/letter_case.hpp"

namespace terravox::analyse {

void check_raster_target(const std::filesystem::path& out) {
    const std::string ending = util::lower_extension(out);
    if (ending != ".tif" && ending != ".tiff")
        throw util::UsageError("write the raster " + out.string() + ": the ending '" + ending +
                               "'; allowed: .tif .tiff");
    util::check_writable(out);
}

void write_raster(GDALDatasetH cells, const std::string& attempt, const std::filesystem::path& out,
                  const output::PictureInfo& info, int threads, bool has_floats) {
    const output::GdalWatch watch(attempt);
    output::describe_geotiff(cells, info, watch);
    GDALFlushCache(cells);
    util::AtomicFile target(out);
    output::CogOptions options;
    options.has_floats = has_floats;
    options.block_px = 256;
    options.overview_resampling = "NEAREST";
    options.threads = std::to_string(threads);
    output::write_cog(cells, target.temporary_path(), options, watch);
    target.commit();
}

void write_raster(CellFile& cells, const std::filesystem::path& out,
                  const output::PictureInfo& info, int threads) {
    write_raster(cells.dataset(), cells.attempt(), out, info, threads, true);
}

}  // namespace terravox::analyse
