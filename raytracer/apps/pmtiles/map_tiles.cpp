#include "raytracer/apps/pmtiles/map_tiles.hpp"

#include <gdal_utils.h>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "common/geo/gdal_files.hpp"
#include "common/thread/in_order.hpp"
#include "common/util/error.hpp"
#include "common/util/handle_pool.hpp"
#include "common/util/log.hpp"
#include "common/util/version.hpp"
#include "raytracer/core/output/gdal_writing.hpp"
#include "raytracer/core/output/progress.hpp"

namespace terravox::pmtiles {
namespace {

constexpr int kBands = 4;

struct OptionsFree {
    void operator()(GDALWarpAppOptions* options) const noexcept { GDALWarpAppOptionsFree(options); }
};

output::GdalDataset open_map(const std::string& file, const output::GdalWatch& watch) {
    const char* const only[] = {"GTiff", nullptr};
    output::GdalDataset out(
        GDALOpenEx(file.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, only, nullptr, nullptr));
    watch.check(out != nullptr);
    return out;
}

}  // namespace

class TileCutter::Maps : public util::HandlePool<output::GdalDataset> {};

TileCutter::TileCutter(const std::filesystem::path& map, int tile_px, std::string attempt)
    : m_attempt(std::move(attempt)),
      m_tile_px(tile_px),
      m_file(map.string()),
      m_maps(std::make_unique<Maps>()) {
    const output::GdalWatch watch(m_attempt);
    const Maps::Lease loan = m_maps->borrow([&] { return open_map(m_file, watch); });
    if (const int bands = GDALGetRasterCount(loan.get()); bands != kBands)
        throw util::Error(m_attempt + ": a map of " + std::to_string(bands) +
                          " bands; allowed: 4, red, green, blue and alpha");
}

TileCutter::~TileCutter() = default;

std::vector<map::Rgba8> TileCutter::cut(const TileAddress& tile) const {
    const output::GdalWatch watch(m_attempt);
    const Maps::Lease loan = m_maps->borrow([&] { return open_map(m_file, watch); });
    const auto [west, south, east, north] = WebArea::measure_bounds(tile);
    const std::string side = std::to_string(m_tile_px);
    std::vector<std::string> words = {"-of", "MEM", "-t_srs", "EPSG:3857", "-te"};
    for (const double edge_m : {west, south, east, north})
        words.push_back(fmt::format("{:.4f}", edge_m));
    words.insert(words.end(), {"-ts", side, side, "-r", "bilinear", "-srcalpha", "-dstalpha"});
    std::vector<char*> pointers;
    for (std::string& word : words)
        pointers.push_back(word.data());
    pointers.push_back(nullptr);
    const std::unique_ptr<GDALWarpAppOptions, OptionsFree> options(
        GDALWarpAppOptionsNew(pointers.data(), nullptr));
    GDALDatasetH from = loan.get();
    const output::GdalDataset warped(GDALWarp("", nullptr, 1, &from, options.get(), nullptr));
    watch.check(warped != nullptr);
    std::vector<map::Rgba8> out(static_cast<std::size_t>(m_tile_px) *
                                static_cast<std::size_t>(m_tile_px));
    static_assert(sizeof(map::Rgba8) == kBands);
    watch.check(GDALDatasetRasterIOEx(warped.get(), GF_Read, 0, 0, m_tile_px, m_tile_px, out.data(),
                                      m_tile_px, m_tile_px, GDT_Byte, kBands, nullptr, kBands,
                                      GSpacing{kBands} * m_tile_px, 1, nullptr) == CE_None);
    if (std::none_of(out.begin(), out.end(), [](const map::Rgba8& pixel) { return pixel.a > 0; }))
        out.clear();
    return out;
}

namespace {

std::string to_webp(const std::vector<map::Rgba8>& pixels, int edge, const std::string& attempt) {
    const output::GdalWatch watch(attempt);
    static_assert(sizeof(map::Rgba8) == kBands);
    const output::GdalDataset picture =
        output::memory_dataset({pixels.data(), GDT_Byte, edge, edge, kBands, 1, kBands}, watch);
    output::GdalOptions options = {{"QUALITY", "85"}};
    return output::encode_in_memory(picture.get(), geo::webp_driver(), options, watch);
}

std::string make_metadata(const MapTexts& texts, int tile_px) {
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

std::uint64_t count_tiles(const WebArea& area) {
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
    const std::uint64_t all = count_tiles(area);
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
            return format == TileFormat::kWebp ? to_webp(pixels, edge, attempt)
                                               : map::to_png(pixels, edge, edge);
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
        {format, area.min_zoom, area.max_zoom, area.bounds_deg(), make_metadata(texts, edge)});
    return count;
}

}  // namespace terravox::pmtiles
