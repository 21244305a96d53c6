// terravox-pictures.so: all that calls OpenImageIO.
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <string>
#include <utility>

#include "common/util/error.hpp"
#include "common/util/text.hpp"
#include "common/util/version.hpp"
#include "raytracer/core/output/picture_file.hpp"

namespace terravox::output {
namespace {

/// A file that OpenImageIO writes to. It remembers a failure: libraries of formats close the files
/// that they open themselves without checking the result, or end the process (libjpeg), so on a
/// full disk the last bytes of a picture could be missing without an error.
class CheckedFile final : public OIIO::Filesystem::IOProxy {
public:
    /// @param attempt begins the messages, such as "write the picture a.exr"
    /// @throws Error when the file cannot be opened for writing
    CheckedFile(const std::filesystem::path& path, std::string attempt)
        : IOProxy(path.string(), Write),
          m_attempt(std::move(attempt)),
          m_file(std::fopen(path.c_str(), "wbe")) {
        note(m_file != nullptr);
        check();
    }

    [[nodiscard]] const char* proxytype() const override { return "checked"; }
    std::int64_t tell() override { return ::ftello(m_file.get()); }
    using IOProxy::seek;
    bool seek(std::int64_t offset) override {
        return note(::fseeko(m_file.get(), offset, SEEK_SET) == 0);
    }
    [[nodiscard]] std::size_t size() const override { return static_cast<std::size_t>(m_end); }
    using IOProxy::write;
    std::size_t write(const void* bytes, std::size_t size) override {
        const std::size_t written = std::fwrite(bytes, 1, size, m_file.get());
        note(written == size);
        m_end = std::max(m_end, tell());
        return written;
    }

    /// @throws Error when not all bytes could be written, with the system's reason
    void finish() {
        note(std::fclose(m_file.release()) == 0);
        check();
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
    bool note(bool done) noexcept {
        if (!done && m_reason == 0)
            m_reason = errno != 0 ? errno : EIO;
        return done;
    }
    std::string m_attempt;
    std::unique_ptr<std::FILE, Close> m_file;
    std::int64_t m_end = 0;
    int m_reason = 0;  ///< errno of the first failure
};

OIIO::TypeDesc to_type(SampleType type) {
    return type == SampleType::kByte   ? OIIO::TypeUInt8
           : type == SampleType::kHalf ? OIIO::TypeHalf
                                       : OIIO::TypeFloat;
}

OIIO::ImageSpec make_spec(const FileShape& shape) {
    OIIO::ImageSpec out(shape.width_px, shape.height_px, static_cast<int>(shape.channels.size()),
                        to_type(shape.channels.front().type));
    out.channelnames.clear();
    for (const FileChannel& channel : shape.channels) {
        if (channel.name == "A")
            out.alpha_channel = static_cast<int>(out.channelnames.size());
        if (channel.name == "Z")
            out.z_channel = static_cast<int>(out.channelnames.size());
        out.channelnames.push_back(channel.name);
        out.channelformats.push_back(to_type(channel.type));
    }
    // Several formats refuse a list, even where all in it are the same.
    if (std::ranges::all_of(out.channelformats, [&](auto type) { return type == out.format; }))
        out.channelformats.clear();
    out.attribute("oiio:ColorSpace", out.format == OIIO::TypeUInt8 ? "sRGB" : "Linear");
    if (!shape.compression.empty())
        out.attribute("compression", shape.compression);
    if (shape.tile_px > 0) {
        out.tile_width = out.tile_height = shape.tile_px;
        out.attribute("openexr:lineOrder", "randomY");
    }
    return out;
}

/// What EXR has a place for, and other formats have not.
void describe_exr(const PictureInfo& info, OIIO::ImageSpec& spec) {
    // Without a date OpenImageIO would write that of today, and a number is none.
    spec.attribute("DateTime", 0);
    constexpr float kRec709[] = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f};
    spec.attribute("chromaticities", OIIO::TypeDesc(OIIO::TypeDesc::FLOAT, 8), kRec709);
    if (info.world_to_camera)
        spec.attribute("worldtocamera", OIIO::TypeMatrix, info.world_to_camera->data());
    if (info.world_to_ndc)
        spec.attribute("worldtoNDC", OIIO::TypeMatrix, info.world_to_ndc->data());
}

std::unique_ptr<OIIO::ImageOutput> make_output(const std::string& ending) {
    auto out = OIIO::ImageOutput::create("x" + ending);
    return out && out->supports("ioproxy") ? std::move(out) : nullptr;
}

class Encoder final : public PictureEncoder {
public:
    Encoder(const std::filesystem::path& file, const std::string& ending, const FileShape& shape,
            const PictureInfo& info, const std::string& attempt)
        : m_attempt(attempt), m_file(file, attempt), m_out(make_output(ending)) {
        if (!m_out)
            throw util::Error(attempt + ": OpenImageIO does not write " + ending);
        OIIO::ImageSpec spec = make_spec(shape);
        for (const auto& [name, value] : info.metadata)
            spec.attribute(name, value);
        if (ending == ".exr")
            describe_exr(info, spec);
        OIIO::Filesystem::IOProxy* file_pointer = &m_file;
        spec.attribute("oiio:ioproxy", OIIO::TypeDesc::PTR, &file_pointer);
        m_is_tiled = shape.tile_px > 0;
        m_type = spec.channelformats.empty() ? spec.format : OIIO::TypeUnknown;
        // Some formats store the name, and that of a file that is being written is one of chance.
        check(m_out->open("picture" + ending, spec));
    }

    void write(const PixelBand& band) override {
        check(m_is_tiled ? m_out->write_tiles(band.x0, band.x1, band.y0, band.y1, 0, 1, m_type,
                                              band.pixels)
                         : m_out->write_scanlines(band.y0, band.y1, 0, m_type, band.pixels));
    }

    void finish() override {
        check(m_out->close());
        m_file.finish();
    }

private:
    /// The system's reason replaces what OpenImageIO says.
    void check(bool done) {
        m_file.check();
        if (!done)
            throw util::Error(m_attempt + ": " + util::printable(m_out->geterror()));
    }

    std::string m_attempt;
    CheckedFile m_file;  // outlives what writes to it
    std::unique_ptr<OIIO::ImageOutput> m_out;
    bool m_is_tiled = false;
    OIIO::TypeDesc m_type;  ///< of all channels; unknown: each has its own
};

constexpr PictureModule kModule = {
    .can_encode = [](const std::string& ending) { return make_output(ending) != nullptr; },
    .encode = [](const std::filesystem::path& file, const std::string& ending,
                 const FileShape& shape, const PictureInfo& info,
                 const std::string& attempt) -> std::unique_ptr<PictureEncoder> {
        return std::make_unique<Encoder>(file, ending, shape, info, attempt);
    },
};

}  // namespace
}  // namespace terravox::output

extern "C" terravox::output::FindPictureModule terravox_find_picture_module;

const terravox::output::PictureModule& terravox_find_picture_module(const char* version) {
    if (std::string(version) != terravox::kVersion)
        throw terravox::util::Error(std::string("use the module of pictures: it is of version ") +
                                    terravox::kVersion + "; allowed: that of the program, " +
                                    version);
    OIIO::attribute("debug", 0);  // Debian's prints to standard error otherwise
    // Formats compress with threads of their own.
    OIIO::attribute("threads", 1);
    return terravox::output::kModule;
}
