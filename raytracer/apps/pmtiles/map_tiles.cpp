#include "raytracer/apps/pmtiles/map_tiles.hpp"

#include <nlohmann/json.hpp>
#include <vector>

#include "common/geo/writing_drivers.hpp"
#include "common/thread/in_order.hpp"
#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/version.hpp"
#include "raytracer/apps/pmtiles/tile_cutter.hpp"
#include "raytracer/core/output/gdal_writing.hpp"
#include "raytracer/core/output/progress.hpp"
#include "voxelserver/serve/map/png.hpp"

namespace terravox::pmtiles {
namespace {

std::string webp_of(const std::vector<map::Rgba8>& pixels, int edge, const std::string& attempt) {
    const output::GdalWatch watch(attempt);
    constexpr int kBands = 4;
    static_assert(sizeof(map::Rgba8) == kBands);
    const output::GdalDataset picture =
        output::memory_dataset({pixels.data(), GDT_Byte, edge, edge, kBands, 1, kBands}, watch);
    output::GdalOptions options = {{"QUALITY", "85"}};
    return output::encode_in_memory(picture.get(), geo::webp_driver(), options, watch);
}

std::string metadata_of(const MapTexts& texts, int tile_px) {
    nlohmann::json out = {{"name", texts.title},
                          {"type", "baselayer"},
                          {"generator", std::string("terravox ") + kVersion}};
    if (!texts.attribution.empty())
        out["attribution"] = texts.attribution;
    if (texts.holes > 0)
        out["holes"] = texts.holes;
    out["tile_px"] = tile_px;
    return out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::uint64_t tiles_of(const WebArea& area) {
    std::uint64_t out = 0;
    for (int zoom = area.min_zoom; zoom <= area.max_zoom; ++zoom)
        out += area.tiles(zoom).size();
    return out;
}

}  // namespace

void check_tile_format(TileFormat format) {
    if (format == TileFormat::kWebp)
        (void)geo::webp_driver();
}

std::uint64_t write_map_tiles(const std::filesystem::path& map, const WebArea& area,
                              const std::filesystem::path& out, TileFormat format,
                              const MapTexts& texts, int threads, bool quiet,
                              const std::function<bool()>& is_stopped) {
    const std::string attempt = "write the map tiles " + out.string();
    check_tile_format(format);  // before other threads use GDAL
    const int edge = area.tile_px;
    const TileCutter cutter(map, edge, attempt);
    ArchiveWriter writer(out);
    std::uint64_t count = 0;
    const std::uint64_t all = tiles_of(area);
    output::Progress progress(all, all, quiet);
    for (int zoom = area.min_zoom; zoom <= area.max_zoom; ++zoom) {
        const std::vector<TileAddress> tiles = area.tiles(zoom);
        util::log_debug("tiles of zoom {} (to {}): {}", zoom, area.max_zoom, tiles.size());
        const auto make = [&](std::size_t i) {
            if (is_stopped())
                throw util::Error(attempt + ": interrupted");
            std::vector<map::Rgba8> pixels = cutter.cut(tiles[i]);
            if (pixels.empty())
                return std::string();
            return format == TileFormat::kWebp ? webp_of(pixels, edge, attempt)
                                               : map::png_of(pixels, edge, edge);
        };
        const auto use = [&](std::size_t i, const std::string& bytes) {
            progress.tile_done(1, 0);
            progress.look({});
            if (bytes.empty())
                return;
            writer.add(tile_id(tiles[i]), bytes);
            ++count;
        };
        thread::in_order(tiles.size(), threads, make, use);
    }
    progress.finish();
    writer.finish(
        {format, area.min_zoom, area.max_zoom, area.bounds_deg(), metadata_of(texts, edge)});
    return count;
}

}  // namespace terravox::pmtiles
