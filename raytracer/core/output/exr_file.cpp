#include "raytracer/core/output/exr_file.hpp"

#include <half.h>
#include <ImathMatrix.h>
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfMatrixAttribute.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <ImfTiledOutputFile.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "common/util/atomic_file.hpp"
#include "common/util/error.hpp"

namespace terravox::output {
namespace {

constexpr const char *kMaterials = "CryptoMaterial", *kSquares = "CryptoSquare";

std::vector<std::string> material_names() {
    std::vector<std::string> out;
    for (int i = 0; i < voxel::kMaterialCount; ++i)
        out.emplace_back(voxel::material_name(static_cast<voxel::Material>(i)));
    return out;
}

/// OpenEXR's name of a text that has a place of its own there.
std::string exr_name(const std::string& name) {
    return name == "Copyright" ? "owner" : name == "ImageDescription" ? "comments" : name;
}

/// Stores the contents of `info` other than light: texts, and the matrices of the camera.
void describe_picture(const PictureInfo& info, Imf::Header& header) {
    for (const auto& [name, value] : info.metadata)
        header.insert(exr_name(name), Imf::StringAttribute(value));
    const auto add_matrix = [&](const char* name, const std::array<float, 16>& values) {
        Imath::M44f matrix;
        std::copy(values.begin(), values.end(), &matrix[0][0]);
        header.insert(name, Imf::M44fAttribute(matrix));
    };
    if (info.world_to_camera)
        add_matrix("worldToCamera", *info.world_to_camera);
    if (info.world_to_ndc)
        add_matrix("worldToNDC", *info.world_to_ndc);
}

/// Writes values one behind the other.
class Writer {
public:
    explicit Writer(std::byte* out) noexcept : m_out(out) {}
    void floats(std::initializer_list<float> values) noexcept {
        for (const float v : values)
            put(v);
    }
    void halves(std::initializer_list<float> values) noexcept {
        constexpr float kMax = 65504;
        for (const float v : values)
            put(half(v > kMax ? kMax : v < -kMax ? -kMax : v));
    }
    void halves(const voxel::Colour& c) noexcept { halves({c.r, c.g, c.b}); }
    void rest(const void* from, std::size_t bytes) noexcept {
        std::memcpy(m_out, from, bytes);
        m_out += bytes;
    }

private:
    template <class T>
    void put(T v) noexcept {
        rest(&v, sizeof v);
    }
    std::byte* m_out;
};

}  // namespace

ExrChannels::ExrChannels(bool with_layers, const PictureInfo& info)
    : m_info(info),
      m_with_layers(with_layers),
      m_materials(kMaterials, with_layers ? material_names() : std::vector<std::string>{}),
      m_squares(kSquares, with_layers ? info.square_names : std::vector<std::string>{}) {
    const auto add = [&](Imf::PixelType type, std::initializer_list<const char*> names) {
        for (const char* name : names) {
            m_channels.push_back({name, type, m_pixel_bytes});
            m_pixel_bytes += type == Imf::HALF ? sizeof(half) : sizeof(float);
        }
    };
    add(Imf::FLOAT, {"R", "G", "B", "A", "Z"});
    if (!with_layers)
        return;
    add(Imf::HALF, {"albedo.R", "albedo.G", "albedo.B", "direct.R", "direct.G", "direct.B",
                    "indirect.R", "indirect.G", "indirect.B", "normal.X", "normal.Y", "normal.Z"});
    add(Imf::FLOAT, {"position.X", "position.Y", "position.Z"});
    add(Imf::HALF, {"material.ID", "sun.V", "water.V"});
    for (const char* type : {kMaterials, kSquares})
        for (const std::string& name : Cryptomatte::channel_names(type))
            add(Imf::FLOAT, {name.c_str()});
}

void ExrChannels::describe(Imf::Header& header) const {
    for (const Channel& channel : m_channels)
        header.channels().insert(channel.name, Imf::Channel(channel.type));
    Imf::addChromaticities(header, Imf::Chromaticities());  // those of Rec. 709
    describe_picture(m_info, header);
    if (!m_with_layers)
        return;
    for (const Cryptomatte* mattes : {&m_materials, &m_squares})
        for (const auto& [key, value] : mattes->metadata())
            header.insert(key, Imf::StringAttribute(value));
}

Imf::FrameBuffer ExrChannels::frame(const std::byte* pixels, const Imath::Box2i& area) const {
    const auto width = static_cast<std::size_t>(area.max.x - area.min.x + 1);
    Imf::FrameBuffer out;
    for (const Channel& channel : m_channels)
        out.insert(channel.name, Imf::Slice::Make(channel.type, pixels + channel.offset, area,
                                                  m_pixel_bytes, m_pixel_bytes * width));
    return out;
}

void ExrChannels::put(const tiles::PixelSample& p, const tiles::LayerSample* layers,
                      std::byte* out) const noexcept {
    Writer to(out);
    to.floats({p.colour.r, p.colour.g, p.colour.b, p.alpha, p.depth_m});
    if (!m_with_layers)
        return;
    const tiles::LayerSample none, &l = layers != nullptr ? *layers : none;
    to.halves(l.albedo);
    to.halves(l.direct);
    to.halves(l.indirect);
    to.halves({l.normal[0], l.normal[1], l.normal[2]});
    to.floats({l.position[0], l.position[1], l.position[2]});
    to.halves({static_cast<float>(l.material), l.sun, l.water});
    for (const auto& ranks : {m_materials.find_ranks(l.materials), m_squares.find_ranks(l.squares)})
        to.rest(ranks.data(), sizeof ranks);
}

namespace {

/// A file that OpenEXR writes to. It remembers a failure, since OpenEXR's destructors ignore it.
class CheckedStream final : public Imf::OStream {
public:
    /// @param attempt begins the messages, such as "write the picture a.exr"
    /// @throws Error when the file cannot be opened for writing
    CheckedStream(const std::filesystem::path& path, std::string attempt)
        : Imf::OStream(path.c_str()),
          m_attempt(std::move(attempt)),
          m_file(std::fopen(path.c_str(), "wbe")) {
        if (!m_file)
            fail();
    }

    void write(const char* bytes, int count) override {
        const auto size = static_cast<std::size_t>(count);
        if (std::fwrite(bytes, 1, size, m_file.get()) != size)
            fail();
    }
    std::uint64_t tellp() override {
        const off_t at = ::ftello(m_file.get());
        if (at < 0)
            fail();
        return static_cast<std::uint64_t>(at);
    }
    void seekp(std::uint64_t at) override {
        if (::fseeko(m_file.get(), static_cast<off_t>(at), SEEK_SET) != 0)
            fail();
    }

    /// @throws Error when not all bytes could be written, with the system's reason
    void close() {
        check();
        if (std::fclose(m_file.release()) != 0)
            fail();
    }
    /// @throws Error when any call before has failed
    void check() const {
        if (m_reason != 0)
            throw util::Error(m_attempt + ": " + std::strerror(m_reason));
    }

private:
    struct Close {
        void operator()(std::FILE* file) const noexcept { std::fclose(file); }
    };

    [[noreturn]] void fail() {
        if (m_reason == 0)
            m_reason = errno != 0 ? errno : EIO;
        check();
        std::terminate();  // check() has thrown
    }

    std::string m_attempt;
    std::unique_ptr<std::FILE, Close> m_file;
    int m_reason = 0;  ///< errno of the first failure
};

Imf::Header make_header(const ExrShape& shape, const ExrChannels& channels) {
    Imf::Header out(shape.width_px, shape.height_px);
    channels.describe(out);
    out.compression() = Imf::ZIP_COMPRESSION;
    // Faster than the default of 4, for somewhat larger files.
    out.zipCompressionLevel() = 2;
    if (shape.tile_px > 0) {
        const auto edge = static_cast<unsigned>(shape.tile_px);
        out.setTileDescription(Imf::TileDescription(edge, edge, Imf::ONE_LEVEL));
        out.lineOrder() = Imf::RANDOM_Y;
    }
    return out;
}

/// The next string of a header, which ends with 0.
std::string next_string(std::istream& in) {
    std::string out;
    std::getline(in, out, '\0');
    return out;
}

/// A number of four bytes, the lowest first.
std::uint32_t next_number(std::istream& in) {
    std::array<unsigned char, 4> bytes{};
    in.read(reinterpret_cast<char*>(bytes.data()), bytes.size());
    std::uint32_t out = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
        out |= static_cast<std::uint32_t>(bytes[i]) << 8 * i;
    return out;
}

/// Goes to the value of a text in the header of a finished file. Ref: "OpenEXR File Layout": magic
/// number and version (4 bytes each), then attributes, each of which is name, 0, type, 0, size (4
/// bytes), value; an empty name ends them.
/// @return whether there is such a text, of that many bytes
bool go_to_text(std::iostream& file, const std::string& name, std::size_t bytes) {
    constexpr std::streamoff kFirstAttribute = 8;
    file.seekg(kFirstAttribute);
    while (file) {
        const std::string found = next_string(file);
        const std::string type = next_string(file);
        const std::uint32_t size = next_number(file);
        if (found.empty())
            return false;
        if (found == name) {
            file.seekp(file.tellg());
            return file && type == "string" && size == bytes;
        }
        file.seekg(size, std::ios::cur);
    }
    return false;
}

/// Replaces a text in the header of a finished file by another of the same length.
/// @throws Error when there is no such text
void replace_text(const std::filesystem::path& file, const std::string& name,
                  const std::string& value, const std::string& attempt) {
    std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
    if (go_to_text(stream, name, value.size())) {
        stream.write(value.data(), static_cast<std::streamsize>(value.size()));
        stream.flush();
        if (stream)
            return;
    }
    throw util::Error(attempt + ": " + name + " in its header cannot be brought up to date");
}

void start_threads() {
    static std::once_flag once;
    std::call_once(once, [] {
        Imf::setGlobalThreadCount(static_cast<int>(std::thread::hardware_concurrency()));
    });
}

}  // namespace

class ExrFile::Parts {
public:
    Parts(const std::filesystem::path& file, const ExrShape& shape, const ExrChannels& channels)
        : m_shape(shape),
          m_channels(channels),
          m_attempt("write the picture " + file.string()),
          m_target(file),
          m_stream(m_target.temporary_path(), m_attempt) {
        with_reasons([&] {
            start_threads();
            const Imf::Header header = make_header(shape, channels);
            if (shape.tile_px > 0)
                m_tiles.emplace(m_stream, header);
            else
                m_rows.emplace(m_stream, header);
        });
    }

    void write(const ExrBand& band) {
        with_reasons([&] {
            const Imf::FrameBuffer frame =
                m_channels.frame(band.pixels, {{band.x0, band.y0}, {band.x1 - 1, band.y1 - 1}});
            if (m_rows) {
                m_rows->setFrameBuffer(frame);
                m_rows->writePixels(band.y1 - band.y0);
                return;
            }
            const int edge = m_shape.tile_px;
            m_tiles->setFrameBuffer(frame);
            m_tiles->writeTiles(band.x0 / edge, (band.x1 - 1) / edge, band.y0 / edge,
                                (band.y1 - 1) / edge);
        });
    }

    void finish(const ImageMetadata& late_texts) {
        // These write the table of offsets.
        m_rows.reset();
        m_tiles.reset();
        m_stream.close();
        for (const auto& [name, value] : late_texts)
            replace_text(m_target.temporary_path(), name, value, m_attempt);
        m_target.commit();
    }

private:
    /// OpenEXR's exceptions become ours, and the system's reason replaces what they say.
    template <class Work>
    void with_reasons(const Work& work) const {
        try {
            work();
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& e) {
            m_stream.check();
            throw util::Error(m_attempt + ": " + e.what());
        }
    }

    ExrShape m_shape;
    const ExrChannels& m_channels;
    std::string m_attempt;
    util::AtomicFile m_target;  // outlives the stream
    CheckedStream m_stream;     // outlives what writes to it
    std::optional<Imf::OutputFile> m_rows;
    std::optional<Imf::TiledOutputFile> m_tiles;
};

ExrFile::ExrFile(const std::filesystem::path& file, const ExrShape& shape,
                 const ExrChannels& channels)
    : m_parts(std::make_unique<Parts>(file, shape, channels)) {}

ExrFile::~ExrFile() = default;

void ExrFile::write(const ExrBand& band) {
    m_parts->write(band);
}

void ExrFile::finish(const ImageMetadata& late_texts) {
    m_parts->finish(late_texts);
}

}  // namespace terravox::output
