#include <algorithm>
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "raytracer/core/output/exr_channels.hpp"
#include "raytracer/core/output/exr_file.hpp"
#include "raytracer/core/output/stream_formats.hpp"

namespace terravox::output {
namespace {

constexpr const char* kHoles = "terravox:holes";
constexpr std::size_t kHolesDigits = 12;

/// With leading zeros: a text whose length does not depend on the number.
std::string digits_of(std::uint64_t n) {
    const std::string text = std::to_string(n);
    return std::string(kHolesDigits - std::min(kHolesDigits, text.size()), '0') + text;
}

PictureInfo with_room_for_holes(PictureInfo info) {
    std::erase_if(info.metadata, [](const auto& item) { return item.first == kHoles; });
    info.metadata.emplace_back(kHoles, digits_of(0));
    return info;
}

class ExrStream final : public TileStream::Format {
public:
    ExrStream(const std::filesystem::path& file, const StreamShape& shape, PictureInfo info)
        : m_info(with_room_for_holes(std::move(info))),
          m_channels(shape.with_layers, m_info),
          m_edge(file_tile_px(shape.tile_px, 1)),
          m_file(file, {shape.width_px, shape.height_px, m_edge}, m_channels) {}

    void write(const tiles::TileResult& result) override {
        const tiles::RenderTile& t = result.tile;
        const auto width = static_cast<std::size_t>(t.x1 - t.x0);
        // A row of the file's tiles at a time: as much as OpenEXR can compress in parallel without
        // twice the memory of the result.
        for (int y0 = t.y0; y0 < t.y1; y0 += m_edge) {
            const int y1 = std::min(y0 + m_edge, t.y1);
            m_band.resize(width * static_cast<std::size_t>(y1 - y0) * m_channels.pixel_bytes());
            std::byte* to = m_band.data();
            const std::size_t begin = static_cast<std::size_t>(y0 - t.y0) * width;
            const std::size_t end = static_cast<std::size_t>(y1 - t.y0) * width;
            for (std::size_t i = begin; i < end; ++i) {
                m_channels.put(result.samples[i],
                               result.layers.empty() ? nullptr : &result.layers[i], to);
                to += m_channels.pixel_bytes();
            }
            m_file.write({t.x0, y0, t.x1, y1, m_band.data()});
        }
    }

    void finish(std::uint64_t holes) override { m_file.finish({{kHoles, digits_of(holes)}}); }

private:
    PictureInfo m_info;
    ExrChannels m_channels;
    int m_edge;
    ExrFile m_file;
    std::vector<std::byte> m_band;
};

}  // namespace

std::unique_ptr<TileStream::Format> make_exr_stream(const std::filesystem::path& file,
                                                    const StreamShape& shape, PictureInfo info) {
    return std::make_unique<ExrStream>(file, shape, std::move(info));
}

}  // namespace terravox::output
