#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <memory>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"
#include "raytracer/output/checked_file.hpp"
#include "raytracer/output/exr_channels.hpp"
#include "raytracer/output/stream_formats.hpp"

namespace terravox::output {
namespace {

constexpr const char* kHoles = "terravox:holes";
constexpr std::size_t kHolesDigits = 12;

/// With leading zeros: a text whose length does not depend on the number.
std::string digits_of(std::uint64_t n) {
    std::string text = std::to_string(n);
    return std::string(kHolesDigits - std::min(kHolesDigits, text.size()), '0') + text;
}

/// Replaces a text in the header of a finished EXR file by another of the same length: the header
/// is written first, and its number of holes is known last. Ref: "OpenEXR file layout": an
/// attribute is name, 0, type, 0, size (4 bytes), value.
void replace_text(const std::filesystem::path& file, const std::string& name,
                  const std::string& value) {
    const std::string before = name + '\0' + "string" + '\0';
    constexpr std::size_t kMaxHeader = std::size_t{1} << 26;
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    std::string header;
    std::array<char, 65536> part{};
    while (stream && header.size() < kMaxHeader) {
        stream.read(part.data(), part.size());
        const std::size_t from = header.size() - std::min(header.size(), before.size());
        header.append(part.data(), static_cast<std::size_t>(stream.gcount()));
        const std::size_t at = header.find(before, from);
        if (at == std::string::npos)
            continue;
        stream.clear();
        stream.seekp(static_cast<std::streamoff>(at + before.size() + 4));
        stream.write(value.data(), static_cast<std::streamsize>(value.size()));
        stream.flush();
        if (stream)
            return;
        break;
    }
    throw util::Error("write the picture " + file.string() +
                      ": its header cannot be brought up to date");
}

class ExrStream final : public TileStream::Format {
public:
    ExrStream(const std::filesystem::path& file, const StreamShape& shape, PictureInfo info)
        : m_info(std::move(info)),
          m_channels(shape.with_layers, m_info),
          m_edge(file_tile_px(shape.tile_px, 1)),
          m_target(file),
          m_name(file.string()),
          m_file(m_target.temporary_path(), "write the picture " + m_name),
          m_out(OIIO::ImageOutput::create(m_name)) {
        if (!m_out)
            throw util::Error("write the picture " + m_name + ": " + OIIO::geterror());
        OIIO::attribute("exr_threads", 0);  // one for each core
        OIIO::ImageSpec spec(shape.width_px, shape.height_px, 4, OIIO::TypeDesc::FLOAT);
        m_channels.describe(spec);
        spec.tile_width = spec.tile_height = m_edge;
        spec.tile_depth = 1;
        spec.attribute("openexr:lineOrder", "randomY");
        spec.attribute("compression", "zip:2");
        spec.attribute(kHoles, digits_of(0));
        m_file.attach_to(spec);
        if (!m_out->open(m_target.temporary_path().string(), spec))
            fail();
    }

    void write(const tiles::TileResult& result) override {
        const tiles::RenderTile& t = result.tile;
        const int width = t.x1 - t.x0;
        // A row of the file's tiles at a time: as much as OpenEXR can compress in parallel without
        // twice the memory of the result.
        for (int y0 = t.y0; y0 < t.y1; y0 += m_edge) {
            const int y1 = std::min(y0 + m_edge, t.y1);
            m_rows.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(y1 - y0) *
                          m_channels.pixel_bytes());
            std::byte* to = m_rows.data();
            for (auto i = static_cast<std::size_t>(y0 - t.y0) * static_cast<std::size_t>(width),
                      end = static_cast<std::size_t>(y1 - t.y0) * static_cast<std::size_t>(width);
                 i < end; ++i) {
                m_channels.put(result.samples[i],
                               result.layers.empty() ? nullptr : &result.layers[i], to);
                to += m_channels.pixel_bytes();
            }
            if (!m_out->write_tiles(t.x0, t.x1, y0, y1, 0, 1, OIIO::TypeDesc::UNKNOWN,
                                    m_rows.data()))
                fail();
        }
    }

    void finish(std::uint64_t holes) override {
        if (!m_out->close())
            fail();
        m_out.reset();
        m_file.close();
        replace_text(m_target.temporary_path(), kHoles, digits_of(holes));
        m_target.commit();
    }

private:
    [[noreturn]] void fail() const {
        throw util::Error("write the picture " + m_name + ": " + m_out->geterror());
    }
    PictureInfo m_info;
    ExrChannels m_channels;
    int m_edge;
    util::AtomicFile m_target;  // outlives the output that writes to it
    std::string m_name;
    CheckedFile m_file;  // must also outlive the output that writes to it
    std::unique_ptr<OIIO::ImageOutput> m_out;
    std::vector<std::byte> m_rows;
};

}  // namespace

std::unique_ptr<TileStream::Format> make_exr_stream(const std::filesystem::path& file,
                                                    const StreamShape& shape, PictureInfo info) {
    return std::make_unique<ExrStream>(file, shape, std::move(info));
}

}  // namespace terravox::output
