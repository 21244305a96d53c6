#pragma once

#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "common/voxel/material.hpp"

namespace terravox::test {

/// A MagicaVoxel file, read without any knowledge of how this project writes it but for the shape
/// of its scene: root, group, models.
struct ReadVox {
    std::map<std::array<int, 3>, int>
        voxels;  ///< x east, y north, z up, in the scene; the colour's index
    std::vector<std::array<int, 3>> sizes;
    std::array<voxel::Rgb8, 257> colours{};  ///< by index, 1 to 255
    std::map<int, std::map<std::string, std::string>> materials;
    std::size_t doubles = 0;  ///< voxels that came more than once
};

class VoxReader {
public:
    static ReadVox read(const std::string& bytes) {
        VoxReader reader{bytes};
        if (bytes.substr(0, 4) != "VOX " || reader.i32(4) != 200 || bytes.substr(8, 4) != "MAIN")
            throw std::runtime_error("no MagicaVoxel 200 file");
        if (reader.i32(12) != 0 || 20 + static_cast<std::size_t>(reader.i32(16)) != bytes.size())
            throw std::runtime_error("MAIN does not fit the file");
        for (std::size_t at = 20; at < bytes.size();)
            at = reader.chunk(at);
        reader.place();
        return reader.m_out;
    }

private:
    using Dict = std::map<std::string, std::string>;
    struct Model {
        std::array<int, 3> size{};
        std::vector<std::array<std::uint8_t, 4>> voxels;
    };
    explicit VoxReader(const std::string& bytes) : m_bytes(bytes) {}

    std::int32_t i32(std::size_t at) const {
        std::int32_t out = 0;
        if (at + 4 > m_bytes.size())
            throw std::runtime_error("the file ends too early");
        std::memcpy(&out, m_bytes.data() + at, 4);
        return out;
    }
    std::int32_t next() { return m_at += 4, i32(m_at - 4); }
    Dict dict() {
        Dict out;
        for (int n = next(); n > 0; --n) {
            const auto text = [&] {
                const auto size = static_cast<std::size_t>(next());
                return m_at += size, m_bytes.substr(m_at - size, size);
            };
            const std::string key = text();
            out[key] = text();
        }
        return out;
    }

    std::size_t chunk(std::size_t at) {
        const std::string id = m_bytes.substr(at, 4);
        const std::size_t end = at + 12 + static_cast<std::size_t>(i32(at + 4));
        if (i32(at + 8) != 0)
            throw std::runtime_error(id + " has children");
        m_at = at + 12;
        if (id == "SIZE") {
            m_models.emplace_back();
            for (int& s : m_models.back().size)
                s = next();
        } else if (id == "XYZI") {
            Model& m = m_models.back();
            m.voxels.resize(static_cast<std::size_t>(next()));
            std::memcpy(m.voxels.data(), m_bytes.data() + m_at, m.voxels.size() * 4);
            m_at += m.voxels.size() * 4;
        } else if (id == "RGBA") {
            for (std::size_t i = 1; i <= 256; ++i, m_at += 4)
                m_out.colours[i] = {static_cast<std::uint8_t>(m_bytes[m_at]),
                                    static_cast<std::uint8_t>(m_bytes[m_at + 1]),
                                    static_cast<std::uint8_t>(m_bytes[m_at + 2])};
        } else if (id == "MATL") {
            const int index = next();
            m_out.materials[index] = dict();
        } else if (id == "nTRN") {
            const int node = next();
            dict();
            m_child[node] = next();
            if (next() != -1)
                throw std::runtime_error("the reserved number is not -1");
            next();
            if (next() != 1)
                throw std::runtime_error("not one frame");
            m_place[node] = dict()["_t"];
        } else if (id == "nGRP") {
            const int node = next();
            dict();
            for (int n = next(); n > 0; --n)
                m_group[node].push_back(next());
        } else if (id == "nSHP") {
            const int node = next();
            dict();
            if (next() != 1)
                throw std::runtime_error("not one model");
            m_shape[node] = next();
            dict();
        } else {
            throw std::runtime_error("unknown chunk " + id);
        }
        if (m_at != end)
            throw std::runtime_error(id + " is not as long as it says");
        return end;
    }

    void place() {
        const auto& group = m_group.at(m_child.at(0));
        if (group.size() != m_models.size())
            throw std::runtime_error("not every model is placed");
        for (const int node : group) {
            const Model& m = m_models.at(static_cast<std::size_t>(m_shape.at(m_child.at(node))));
            std::array<int, 3> middle{};
            if (std::sscanf(m_place.at(node).c_str(), "%d %d %d", &middle[0], &middle[1],
                            &middle[2]) != 3)
                throw std::runtime_error("no place");
            m_out.sizes.push_back(m.size);
            for (const auto& v : m.voxels) {
                std::array<int, 3> at{};
                for (std::size_t a = 0; a < 3; ++a) {
                    if (v[a] >= m.size[a])
                        throw std::runtime_error("a voxel lies outside its model");
                    at[a] = middle[a] - m.size[a] / 2 + v[a];
                }
                if (!m_out.voxels.emplace(at, v[3]).second)
                    ++m_out.doubles;
            }
        }
    }

    const std::string& m_bytes;
    std::size_t m_at = 0;
    std::vector<Model> m_models;
    std::map<int, int> m_child;
    std::map<int, int> m_shape;
    std::map<int, std::string> m_place;
    std::map<int, std::vector<int>> m_group;
    ReadVox m_out;
};

}  // namespace terravox::test
