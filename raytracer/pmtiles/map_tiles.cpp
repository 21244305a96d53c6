#include "raytracer/pmtiles/map_tiles.hpp"

#include <cpl_vsi.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "common/geo/writing_drivers.hpp"
#include "common/thread/in_order.hpp"
#include "common/util/error.hpp"
#include "common/util/markup.hpp"
#include "common/util/version.hpp"
#include "raytracer/output/gdal_writing.hpp"
#include "raytracer/pmtiles/tile_cutter.hpp"
#include "voxelserver/map/png.hpp"

namespace terravox::pmtiles {
namespace {

constexpr int kEdge = TileCutter::kTile_px;

struct FreeBytes {
    void operator()(GByte* bytes) const noexcept { VSIFree(bytes); }
};

std::string webp_of(std::vector<map::Rgba8>& pixels, const TileAddress& tile,
                    const std::string& attempt) {
    const output::GdalWatch watch(attempt);
    constexpr int kBands = 4;
    const output::GdalDataset picture(
        GDALCreate(GDALGetDriverByName("MEM"), "", kEdge, kEdge, kBands, GDT_Byte, nullptr));
    watch.check(picture != nullptr);
    watch.check(GDALDatasetRasterIOEx(picture.get(), GF_Write, 0, 0, kEdge, kEdge, pixels.data(),
                                      kEdge, kEdge, GDT_Byte, kBands, nullptr, kBands,
                                      GSpacing{kBands} * kEdge, 1, nullptr) == CE_None);
    GDALSetRasterColorInterpretation(GDALGetRasterBand(picture.get(), kBands), GCI_AlphaBand);
    // A file in memory, which no other tile has.
    const std::string name = "/vsimem/tile-" + std::to_string(tile_id(tile)) + ".webp";
    output::GdalOptions options = {{"QUALITY", "85"}};
    output::GdalDataset file(GDALCreateCopy(geo::webp_driver(), name.c_str(), picture.get(), FALSE,
                                            options.list(), nullptr, nullptr));
    watch.check(file != nullptr);
    file.reset();
    vsi_l_offset bytes = 0;
    const std::unique_ptr<GByte, FreeBytes> packed(VSIGetMemFileBuffer(name.c_str(), &bytes, TRUE));
    watch.check(packed != nullptr);
    return {reinterpret_cast<const char*>(packed.get()), bytes};
}

std::string metadata_of(const MapTexts& texts) {
    nlohmann::json out = {{"name", texts.title},
                          {"type", "baselayer"},
                          {"generator", std::string("terravox ") + kVersion}};
    // Pages take it for HTML.
    if (!texts.attribution.empty())
        out["attribution"] = util::escaped_markup(texts.attribution);
    return out.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

std::uint64_t write_map_tiles(const std::filesystem::path& map, const std::filesystem::path& out,
                              TileFormat format, const MapTexts& texts, int threads,
                              const std::function<bool()>& is_stopped) {
    const std::string attempt = "write the map tiles " + out.string();
    if (format == TileFormat::kWebp)
        (void)geo::webp_driver();  // before other threads use GDAL, and before any work
    const TileCutter cutter(map);
    ArchiveWriter writer(out);
    std::uint64_t count = 0;
    for (int zoom = cutter.min_zoom(); zoom <= cutter.max_zoom(); ++zoom) {
        const std::vector<TileAddress> tiles = cutter.tiles(zoom);
        const auto make = [&](std::size_t i) {
            if (is_stopped())
                throw util::Error(attempt + ": interrupted");
            std::vector<map::Rgba8> pixels = cutter.cut(tiles[i]);
            if (pixels.empty())
                return std::string();
            return format == TileFormat::kWebp ? webp_of(pixels, tiles[i], attempt)
                                               : map::png_of(pixels, kEdge, kEdge);
        };
        const auto use = [&](std::size_t i, const std::string& bytes) {
            if (bytes.empty())
                return;
            writer.add(tile_id(tiles[i]), bytes);
            ++count;
        };
        thread::in_order(tiles.size(), threads, make, use);
    }
    writer.finish(
        {format, cutter.min_zoom(), cutter.max_zoom(), cutter.bounds_deg(), metadata_of(texts)});
    return count;
}

}  // namespace terravox::pmtiles
