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

void write_raster(CellFile& cells, const std::filesystem::path& out,
                  const output::PictureInfo& info, int threads) {
    const output::GdalWatch watch(cells.attempt());
    output::describe_geotiff(cells.dataset(), info, watch);
    GDALFlushCache(cells.dataset());
    util::AtomicFile target(out);
    output::CogOptions options;
    options.has_floats = true;
    options.block_px = 256;
    options.overview_resampling = "NEAREST";
    options.threads = std::to_string(threads);
    output::write_cog(cells.dataset(), target.temporary_path(), options, watch);
    target.commit();
}

}  // namespace terravox::analyse
