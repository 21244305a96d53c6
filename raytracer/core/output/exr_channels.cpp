#include "raytracer/core/output/exr_channels.hpp"

#include <half.h>
#include <ImathMatrix.h>
#include <ImfChannelList.h>
#include <ImfMatrixAttribute.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <cstring>

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
    for (const auto& ranks : {m_materials.ranks_of(l.materials), m_squares.ranks_of(l.squares)})
        to.rest(ranks.data(), sizeof ranks);
}

}  // namespace terravox::output
