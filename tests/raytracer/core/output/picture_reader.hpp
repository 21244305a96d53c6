#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "raytracer/core/output/picture.hpp"
#include "tests/common/picture_file.hpp"

namespace terravox::test {

inline bool same_bits(float a, float b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}

inline std::size_t entries_in(const std::filesystem::path& folder) {
    return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder),
                                                  std::filesystem::directory_iterator()));
}

/// The header of an EXR file, read without any library. Ref: "OpenEXR file layout".
struct ExrHeader {
    struct Attribute {
        std::string type;
        std::string value;
    };
    std::map<std::string, Attribute> attributes;
    std::map<std::string, int> channels;  ///< type: 0 unsigned, 1 half, 2 float
    bool tiled = false;

    explicit ExrHeader(const std::filesystem::path& file) {
        std::ifstream in(file, std::ios::binary);
        if (number(in) != 20000630)
            throw std::runtime_error("no EXR: " + file.string());
        tiled = (number(in) & 0x200) != 0;
        for (std::string name = text(in); !name.empty(); name = text(in)) {
            Attribute a{text(in), {}};
            a.value.resize(static_cast<std::size_t>(number(in)));
            in.read(a.value.data(), static_cast<std::streamsize>(a.value.size()));
            attributes[name] = a;
        }
        const std::string& list = attributes.at("channels").value;
        for (std::size_t at = 0; list[at] != '\0';) {
            const std::string name = list.c_str() + at;
            at += name.size() + 1;
            std::int32_t type;
            std::memcpy(&type, &list[at], 4);
            channels[name] = type;
            at += 16;
        }
    }
    [[nodiscard]] std::array<float, 16> matrix(const std::string& name) const {
        const Attribute& a = attributes.at(name);
        if (a.type != "m44f" || a.value.size() != 64)
            throw std::runtime_error(name + " is a " + a.type);
        std::array<float, 16> out;
        std::memcpy(out.data(), a.value.data(), 64);
        return out;
    }

private:
    static std::int32_t number(std::istream& in) {
        std::int32_t v = 0;
        in.read(reinterpret_cast<char*>(&v), 4);
        return v;
    }
    static std::string text(std::istream& in) {
        std::string out;
        std::getline(in, out, '\0');
        return out;
    }
};

/// A rectangle of a picture that exists in no other place: what stands at (x, y) is a function of x
/// and y.
inline tiles::TileResult synthetic_tile(int x0, int y0, int x1, int y1, bool with_layers) {
    tiles::TileResult out;
    out.tile.x0 = x0;
    out.tile.y0 = y0;
    out.tile.x1 = x1;
    out.tile.y1 = y1;
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
            std::minstd_rand random(static_cast<unsigned>(y * 65536 + x + 1));
            random.discard(2);
            const auto value = [&](float most) {
                return most * static_cast<float>(random() % 65536) / 65536.0f;
            };
            tiles::PixelSample& p = out.samples.emplace_back();
            p.colour = {value(4), value(4e-5f), value(4e4f)};
            p.alpha = value(1);
            p.depth_m = random() % 7 == 0 ? std::numeric_limits<float>::infinity() : value(4000);
            if (!with_layers)
                continue;
            tiles::LayerSample& l = out.layers.emplace_back();
            l.albedo = {value(1), value(1), value(1)};
            l.direct = {value(3), value(3), value(1e6f)};
            l.indirect = {value(3), value(3), value(3)};
            l.normal = {value(2) - 1, value(2) - 1, value(2) - 1};
            l.position = {value(1e6f), value(3000), -value(1e6f)};
            l.sun = value(1);
            l.water = value(1);
            l.material = static_cast<voxel::Material>(random() % voxel::kMaterialCount);
            for (int n = static_cast<int>(random() % 5); n > 0; --n)
                l.materials.add(static_cast<std::uint32_t>(random() % voxel::kMaterialCount),
                                value(0.2f) + 0.001f);
            for (int n = static_cast<int>(random() % 4); n > 0; --n)
                l.squares.add(static_cast<std::uint32_t>(random() % 5), 0.25f);
        }
    return out;
}

}  // namespace terravox::test
