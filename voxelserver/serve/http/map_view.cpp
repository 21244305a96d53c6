#include "voxelserver/serve/http/map_view.hpp"

#include <xxhash.h>
#include <map>
#include <vector>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "voxelserver/serve/http/route_answers.hpp"
#include "voxelserver/serve/map/pixels.hpp"

namespace terravox::http {
namespace {

// To be incremented when the same boxes are drawn differently.
constexpr std::uint64_t kDrawing = 1;
constexpr std::size_t kMaxColumns = 1'000'000;

std::uint64_t appearance_hash(const map::TopColours& colours) {
    std::string facts = std::to_string(kDrawing) + "|" + std::to_string(colours.true_percent) +
                        "|" + std::to_string(colours.true_percent_water);
    for (int i = 0; i < voxel::kMaterialCount; ++i) {
        const auto& look = colours.palette.of(static_cast<voxel::Material>(i));
        for (const int channel : {look.colour.r, look.colour.g, look.colour.b})
            facts += "|" + std::to_string(channel);
    }
    return XXH3_64bits(facts.data(), facts.size());
}

voxel::BoxKey to_key(int z, std::int32_t x, std::int32_t y) {
    return {z, x, 0, y};
}

}  // namespace

MapView::MapView(boxes::BoxCache& cache, map::TopColours colours, std::size_t memory_bytes)
    : m_cache(cache),
      m_look(appearance_hash(colours)),
      m_tops([this](std::int32_t bx, std::int32_t bz, bool make) { return fetch(bx, bz, make); },
             std::move(colours), cache.world().info().levels, memory_bytes / 2),
      m_tiles(cache.world().info(), m_tops, memory_bytes / 2) {
    m_cache.set_listener([this](const voxel::BoxKey& key) { note(key); });
}

void MapView::scan_disk() {
    if (m_cache.disk() != nullptr)
        m_scan_thread = std::thread([this] { note_boxes_on_disk(); });
}

MapView::~MapView() {
    m_cache.close();  // the listener is not called from now on
    m_stop = true;
    if (m_scan_thread.joinable())
        m_scan_thread.join();
    m_cache.set_listener({});
}

map::Tile MapView::get(int z, std::int32_t x, std::int32_t y) {
    boxes::DiskCache* disk = m_cache.disk();
    const bool has_zoom = z >= 0 && z < m_tiles.zooms();
    if (disk != nullptr && has_zoom)
        if (const auto found = disk->find(boxes::Kind::kMapTile, to_key(z, x, y));
            found && found->tag == m_look)
            return {found->bytes, true, found->reach};
    const boxes::Slots::Permit permit(m_cache.slots());
    const map::Tile tile = m_tiles.get(z, x, y);
    // Outside the world there are infinitely many empty tiles, which need not be stored.
    if (disk != nullptr && tile.complete && !tile.reach.empty())
        disk->put(boxes::Kind::kMapTile, to_key(z, x, y), {m_look, tile.png, tile.reach});
    return tile;
}

const std::shared_ptr<const std::string>& MapView::empty_tile() {
    static const auto tile = std::make_shared<const std::string>(
        map::to_png(std::vector<map::Rgba8>(std::size_t{map::kTilePx} * map::kTilePx), map::kTilePx,
                    map::kTilePx));
    return tile;
}

std::optional<map::ColumnBoxes> MapView::fetch(std::int32_t bx, std::int32_t bz, bool make) {
    const voxel::ColumnExtent column = m_cache.world().column(0, bx, bz);
    map::ColumnBoxes out;
    for (std::int32_t by = column.by_begin; by < column.by_end; ++by) {
        const voxel::BoxKey key{0, bx, by, bz};
        const auto found = make ? m_cache.find_or_make(key) : m_cache.peek(key);
        if (!found)
            return std::nullopt;
        out.boxes.push_back(boxes::BoxCache::decompress(*found, key));
        out.reach.add(found->reach);
    }
    return out;
}

// A column is shown once all of its boxes are available.
void MapView::note(const voxel::BoxKey& key) {
    if (key.level != 0)
        return;
    try {
        const voxel::ColumnExtent column = m_cache.world().column(0, key.bx, key.bz);
        for (std::int32_t by = column.by_begin; by < column.by_end; ++by)
            if (by != key.by && !m_cache.peek({0, key.bx, by, key.bz}))
                return;
        m_tops.note_made(key.bx, key.bz);
    } catch (const util::Error& e) {
        // A remote world's server does not respond: the box itself was made, and the request for
        // it must not fail.
        util::log_debug("show box {} on the map: {}", voxel::to_string(key), e.what());
    }
}

void MapView::note_boxes_on_disk() {
    try {
        std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> boxes_of;
        for (const voxel::BoxKey& key : m_cache.disk()->keys(boxes::Kind::kBox, 0, kMaxColumns))
            ++boxes_of[{key.bx, key.bz}];
        for (const auto& [place, count] : boxes_of) {
            if (m_stop)
                return;
            const auto column = m_cache.world().column(0, place.first, place.second);
            if (count >= column.by_end - column.by_begin)
                m_tops.note_made(place.first, place.second);
        }
    } catch (const std::exception& e) {
        util::log_warn("list the boxes on disk: {}; overviews of the map begin empty", e.what());
    }
}

Response answer_map_tile(Service& service, const RouteRequest& call) {
    constexpr std::string_view kEnding = ".png";
    const auto& part = call.parts.part;
    const auto z = parse_int32(part[1]);
    const auto x = parse_int32(part[2]);
    const auto y = parse_int32(part[3].substr(0, part[3].size() - kEnding.size()));
    if (!z || !x || !y)
        return not_numbers(call.request);
    if (service.map == nullptr)
        return problem(404, "this server has no map");
    map::Tile tile;
    try {
        tile = service.map->get(*z, *x, *y);
    } catch (const util::UsageError& e) {
        return problem(404, e.what());
    }
    const auto& png = tile.png ? tile.png : MapView::empty_tile();
    Response out;
    if (tile.complete) {
        const std::string etag = make_etag(XXH64(png->data(), png->size(), 0), "m");
        if (etag_matches(call.request.header("If-None-Match"), etag))
            return not_modified(etag);
        add_validators(out, etag);
    } else {
        out.add("Cache-Control", "no-store");
    }
    out.add("Content-Type", "image/png").add("Terravox-Complete", tile.complete ? "yes" : "no");
    out.body = png;
    return out;
}

}  // namespace terravox::http
