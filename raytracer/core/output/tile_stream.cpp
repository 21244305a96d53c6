#include "raytracer/core/output/tile_stream.hpp"

#include <algorithm>
#include <string>

#include "common/util/error.hpp"
#include "common/util/letter_case.hpp"
#include "raytracer/core/output/film.hpp"
#include "raytracer/core/output/stream_formats.hpp"

namespace terravox::output {
namespace {

int tiles_along(int size_px, int tile_px) noexcept {
    return (size_px + tile_px - 1) / tile_px;
}

}  // namespace

bool must_stream(const StreamShape& s, std::uint64_t limit_bytes) noexcept {
    return Film::bytes(s.width_px, s.height_px, s.with_layers) > limit_bytes;
}

std::uint64_t memory_to_keep_mib(const StreamShape& s) noexcept {
    constexpr std::uint64_t kHalfMib = std::uint64_t{1} << 19;
    return (Film::bytes(s.width_px, s.height_px, s.with_layers) + kHalfMib - 1) / kHalfMib;
}

void check_can_stream(const std::filesystem::path& file, const StreamShape& s) {
    constexpr int kTiffTiles = 16;
    const std::string ending = util::lower_extension(file);
    const std::string attempt = "write the picture " + file.string() + ": ";
    const std::string memory = std::to_string(memory_to_keep_mib(s));
    if (ending == ".exr")
        return;
    if (ending != ".tif" && ending != ".tiff")
        throw util::UsageError(
            attempt + std::to_string(s.width_px) + "x" + std::to_string(s.height_px) +
            " pixels need " +
            std::to_string(Film::bytes(s.width_px, s.height_px, s.with_layers) >> 20) +
            " MiB, more than there is for a picture, and '" + ending +
            "' cannot be written in parts; allowed at this size: .exr .tif, or --memory-mib " +
            memory + " and more");
    if (file_tile_px(s.tile_px, kTiffTiles) == 0)
        throw util::UsageError(
            attempt + "tiles of " + std::to_string(s.tile_px) +
            " pixels; allowed for .tif at this size: multiples of 16, or --memory-mib " + memory +
            " and more");
}

int file_tile_px(int tile_px, int multiple_of) noexcept {
    constexpr int kMax = 512;
    constexpr int kMin = 16;
    for (int edge = std::min(tile_px, kMax); edge >= kMin; --edge)
        if (tile_px % edge == 0 && edge % multiple_of == 0)
            return edge;
    return multiple_of == 1 ? tile_px : 0;
}

TileStream::TileStream(const std::filesystem::path& file, const StreamShape& shape,
                       PictureInfo info)
    : m_shape(shape) {
    check_can_stream(file, shape);
    const auto columns = static_cast<std::uint64_t>(tiles_along(shape.width_px, shape.tile_px));
    const auto rows = static_cast<std::uint64_t>(tiles_along(shape.height_px, shape.tile_px));
    m_left = columns * rows;
    m_done.resize(m_left);
    m_format = util::lower_extension(file) == ".exr"
                   ? make_exr_stream(file, shape, with_clean_texts(std::move(info)))
                   : make_tiff_stream(file, shape, with_clean_texts(std::move(info)));
}

TileStream::~TileStream() = default;

void TileStream::check_tile(const tiles::RenderTile& t) {
    const int edge = m_shape.tile_px;
    const bool fits = t.step == 1 && !t.refines && t.x0 >= 0 && t.y0 >= 0 && t.x0 % edge == 0 &&
                      t.y0 % edge == 0 && t.x0 < m_shape.width_px && t.y0 < m_shape.height_px &&
                      t.x1 == std::min(t.x0 + edge, m_shape.width_px) &&
                      t.y1 == std::min(t.y0 + edge, m_shape.height_px);
    const auto place = [&] {
        return "(" + std::to_string(t.x0) + ", " + std::to_string(t.y0) + ")";
    };
    if (!fits)
        throw util::Error("stream the picture: the tile at " + place() +
                          " is none of a single pass in tiles of " + std::to_string(edge) +
                          " pixels");
    const auto index = static_cast<std::size_t>(t.y0 / edge) *
                           static_cast<std::size_t>(tiles_along(m_shape.width_px, edge)) +
                       static_cast<std::size_t>(t.x0 / edge);
    if (m_done[index])
        throw util::Error("stream the picture: the tile at " + place() + " came twice");
    m_done[index] = true;
    --m_left;
}

void TileStream::add(const tiles::TileResult& result) {
    if (!m_format)
        throw util::Error("stream the picture: a tile came after the end");
    check_tile(result.tile);
    const auto pixels = static_cast<std::size_t>(result.tile.x1 - result.tile.x0) *
                        static_cast<std::size_t>(result.tile.y1 - result.tile.y0);
    if (result.samples.size() != pixels || (m_shape.with_layers && result.layers.size() != pixels))
        throw util::Error("stream the picture: a tile of " + std::to_string(pixels) +
                          " pixels has " + std::to_string(result.samples.size()) + " samples and " +
                          std::to_string(result.layers.size()) + " of its layers");
    m_format->write(result);
}

void TileStream::finish(std::uint64_t holes) {
    if (!m_format)
        throw util::Error("stream the picture: ended twice");
    if (m_left > 0)
        throw util::Error("stream the picture: " + std::to_string(m_left) + " tiles are missing");
    m_format->finish(holes);
    m_format.reset();
}

}  // namespace terravox::output
