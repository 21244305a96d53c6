#include "raytracer/core/output/exr_channels.hpp"

#include <half.h>

#include <cstring>
#include <initializer_list>
#include <string>

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
    const auto add = [&](SampleType type, std::initializer_list<const char*> names) {
        for (const char* name : names) {
            m_list.push_back({name, type});
            m_pixel_bytes += type == SampleType::kHalf ? sizeof(half) : sizeof(float);
        }
    };
    add(SampleType::kFloat, {"R", "G", "B", "A", "Z"});
    if (!with_layers)
        return;
    add(SampleType::kHalf,
        {"albedo.R", "albedo.G", "albedo.B", "direct.R", "direct.G", "direct.B", "indirect.R",
         "indirect.G", "indirect.B", "normal.X", "normal.Y", "normal.Z"});
    add(SampleType::kFloat, {"position.X", "position.Y", "position.Z"});
    add(SampleType::kHalf, {"material.ID", "sun.V", "water.V"});
    for (const char* type : {kMaterials, kSquares})
        for (const std::string& name : Cryptomatte::channel_names(type))
            add(SampleType::kFloat, {name.c_str()});
    for (const Cryptomatte* mattes : {&m_materials, &m_squares})
        for (auto& text : mattes->metadata())
            m_info.metadata.push_back(std::move(text));
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

}  // namespace terravox::output
