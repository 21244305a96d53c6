#include "raytracer/output/exr_channels.hpp"

#include <OpenImageIO/half.h>

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
    const auto add = [&](OIIO::TypeDesc type, std::initializer_list<const char*> names) {
        for (const char* name : names) {
            m_names.emplace_back(name);
            m_types.push_back(type);
        }
    };
    const OIIO::TypeDesc half_type = OIIO::TypeDesc::HALF;
    const OIIO::TypeDesc float_type = OIIO::TypeDesc::FLOAT;
    add(float_type, {"R", "G", "B", "A", "Z"});
    if (with_layers) {
        add(half_type,
            {"albedo.R", "albedo.G", "albedo.B", "direct.R", "direct.G", "direct.B", "indirect.R",
             "indirect.G", "indirect.B", "normal.X", "normal.Y", "normal.Z"});
        add(float_type, {"position.X", "position.Y", "position.Z"});
        add(half_type, {"material.ID", "sun.V", "water.V"});
        for (const char* type : {kMaterials, kSquares})
            for (const std::string& name : Cryptomatte::channel_names(type))
                add(float_type, {name.c_str()});
    }
    for (const OIIO::TypeDesc& type : m_types)
        m_pixel_bytes += type.size();
}

void ExrChannels::describe(OIIO::ImageSpec& spec) const {
    spec.nchannels = static_cast<int>(m_names.size());
    spec.channelnames = m_names;
    spec.format = OIIO::TypeDesc::FLOAT;
    spec.channelformats = m_with_layers ? m_types : std::vector<OIIO::TypeDesc>{};
    spec.alpha_channel = 3;
    spec.z_channel = 4;
    spec.attribute("oiio:ColorSpace", "Linear");
    describe_picture(m_info, spec);
    if (!m_with_layers)
        return;
    for (const Cryptomatte* mattes : {&m_materials, &m_squares})
        for (const auto& [key, value] : mattes->metadata())
            spec.attribute(key, value);
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

void describe_picture(const PictureInfo& info, OIIO::ImageSpec& spec) {
    for (const auto& [key, value] : info.metadata)
        spec.attribute(key, value);
    const OIIO::TypeDesc matrix(OIIO::TypeDesc::FLOAT, OIIO::TypeDesc::MATRIX44);
    if (info.world_to_camera)
        spec.attribute("worldtocamera", matrix, info.world_to_camera->data());
    if (info.world_to_ndc)
        spec.attribute("worldtoNDC", matrix, info.world_to_ndc->data());
}

}  // namespace terravox::output
