#include "raytracer/apps/pmtiles/tile_cutter.hpp"

#include <gdal_utils.h>

#include <algorithm>
#include <cstdio>
#include <mutex>
#include <utility>

#include "common/util/error.hpp"
#include "raytracer/apps/pmtiles/web_area.hpp"
#include "raytracer/core/output/gdal_writing.hpp"

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

std::string metres(double v) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4f", v);
    return text;
}

}  // namespace

/// Open datasets of the map, one for each thread that cuts: GDAL's are not thread-safe.
class TileCutter::DatasetPool {
public:
    explicit DatasetPool(std::string file) : m_file(std::move(file)) {}

    /// Lends a dataset, and takes it back.
    class Loan {
    public:
        Loan(DatasetPool& pool, const output::GdalWatch& watch) : m_pool(pool) {
            {
                const std::scoped_lock lock(pool.m_mutex);
                if (!pool.m_idle.empty()) {
                    m_map = std::move(pool.m_idle.back());
                    pool.m_idle.pop_back();
                }
            }
            if (!m_map)
                m_map = open_map(pool.m_file, watch);
        }
        ~Loan() {
            try {
                const std::scoped_lock lock(m_pool.m_mutex);
                m_pool.m_idle.push_back(std::move(m_map));
            } catch (...) {
                m_map.reset();  // without memory it is closed, and opened again
            }
        }
        Loan(const Loan&) = delete;
        Loan& operator=(const Loan&) = delete;
        [[nodiscard]] GDALDatasetH get() const noexcept { return m_map.get(); }

    private:
        DatasetPool& m_pool;
        output::GdalDataset m_map;
    };

private:
    const std::string m_file;
    std::mutex m_mutex;
    std::vector<output::GdalDataset> m_idle;
};

TileCutter::TileCutter(const std::filesystem::path& map, int tile_px, std::string attempt)
    : m_attempt(std::move(attempt)),
      m_tile_px(tile_px),
      m_maps(std::make_unique<DatasetPool>(map.string())) {
    const output::GdalWatch watch(m_attempt);
    const DatasetPool::Loan loan(*m_maps, watch);
    if (const int bands = GDALGetRasterCount(loan.get()); bands != kBands)
        throw util::Error(m_attempt + ": a map of " + std::to_string(bands) +
                          " bands; allowed: 4, red, green, blue and alpha");
}

TileCutter::~TileCutter() = default;

std::vector<map::Rgba8> TileCutter::cut(const TileAddress& tile) const {
    const output::GdalWatch watch(m_attempt);
    const DatasetPool::Loan loan(*m_maps, watch);
    const auto [west, south, east, north] = WebArea::bounds_of(tile);
    const std::string side = std::to_string(m_tile_px);
    std::vector<std::string> words = {"-of", "MEM", "-t_srs", "EPSG:3857", "-te"};
    words.insert(words.end(), {metres(west), metres(south), metres(east), metres(north)});
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

}  // namespace terravox::pmtiles
