#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace terravox::test {

/// A mesh as a reader of the format sees it: polygons with corners in metres.
struct ReadMesh {
    struct Face {
        std::vector<std::array<double, 3>> corners;
        std::array<double, 3> colour{};  ///< of its first corner: as the file has it, 0 to 1
        std::string material;
    };
    std::vector<Face> faces;
    std::size_t vertices = 0;
    nlohmann::json head;

    /// Twice the area times the normal.
    static std::array<double, 3> normal(const Face& f) {
        std::array<double, 3> out{};
        for (std::size_t i = 1; i + 1 < f.corners.size(); ++i) {
            std::array<double, 3> a{};
            std::array<double, 3> b{};
            for (std::size_t k = 0; k < 3; ++k) {
                a[k] = f.corners[i][k] - f.corners[0][k];
                b[k] = f.corners[i + 1][k] - f.corners[0][k];
            }
            for (std::size_t k = 0; k < 3; ++k)
                out[k] += a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
        }
        return out;
    }
    [[nodiscard]] double area() const {
        double sum = 0;
        for (const Face& f : faces) {
            const auto n = normal(f);
            sum += std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) / 2;
        }
        return sum;
    }
    /// What the faces enclose, when they are closed and attributes outwards. Ref: the divergence
    /// theorem.
    [[nodiscard]] double volume() const {
        double sum = 0;
        for (const Face& f : faces) {
            const auto n = normal(f);
            for (std::size_t k = 0; k < 3; ++k)
                sum += f.corners[0][k] * n[k] / 6;
        }
        return sum;
    }
};

template <class T>
T value_at(const std::string& bytes, std::size_t at) {
    if (at + sizeof(T) > bytes.size())
        throw std::runtime_error("the file ends too early");
    T out;
    std::memcpy(&out, bytes.data() + at, sizeof out);
    return out;
}

/// Triangles of a glTF binary file as this project writes them: one buffer, indices of 32 bits.
inline ReadMesh read_glb(const std::string& bytes) {
    ReadMesh out;
    const auto u32 = [&](std::size_t at) { return value_at<std::uint32_t>(bytes, at); };
    if (bytes.substr(0, 4) != "glTF" || u32(4) != 2 || u32(8) != bytes.size() ||
        bytes.substr(16, 4) != "JSON")
        throw std::runtime_error("no glTF 2 file");
    const std::size_t json_bytes = u32(12);
    const std::size_t bin = 20 + json_bytes + 8;
    if (json_bytes % 4 != 0 || bytes.substr(bin - 4, 4) != std::string("BIN\0", 4) ||
        bin + u32(bin - 8) != bytes.size())
        throw std::runtime_error("chunks do not fit");
    out.head = nlohmann::json::parse(bytes.substr(20, json_bytes));
    for (const auto& primitive : out.head["meshes"][0]["primitives"]) {
        const auto accessor = [&](const nlohmann::json& index) {
            return out.head["accessors"][index.get<std::size_t>()];
        };
        const auto start = [&](const nlohmann::json& a) {
            return bin +
                   out.head["bufferViews"][a["bufferView"].get<std::size_t>()]["byteOffset"]
                       .get<std::size_t>() +
                   a["byteOffset"].get<std::size_t>();
        };
        const auto position = accessor(primitive["attributes"]["POSITION"]);
        const auto colour = accessor(primitive["attributes"]["COLOR_0"]);
        const auto index = accessor(primitive["indices"]);
        const auto stride =
            out.head["bufferViews"][position["bufferView"].get<std::size_t>()]["byteStride"]
                .get<std::size_t>();
        const auto count = position["count"].get<std::size_t>();
        out.vertices += count;
        const std::string material =
            out.head["materials"][primitive["material"].get<std::size_t>()]["name"];
        std::array<double, 3> lowest{1e9, 1e9, 1e9};
        std::array<double, 3> highest{-1e9, -1e9, -1e9};
        for (std::size_t i = 0; i < index["count"].get<std::size_t>(); i += 3) {
            ReadMesh::Face face;
            face.material = material;
            for (std::size_t k = 0; k < 3; ++k) {
                const std::uint32_t v = u32(start(index) + 4 * (i + k));
                if (v >= count)
                    throw std::runtime_error("an index leads outside");
                std::array<double, 3> p{};
                for (std::size_t a = 0; a < 3; ++a) {
                    p[a] = value_at<float>(bytes, start(position) + v * stride + 4 * a);
                    lowest[a] = std::min(lowest[a], p[a]);
                    highest[a] = std::max(highest[a], p[a]);
                    if (k == 0)
                        face.colour[a] =
                            value_at<std::uint16_t>(bytes, start(colour) + v * stride + 2 * a) /
                            65535.0;
                }
                face.corners.push_back(p);
            }
            out.faces.push_back(std::move(face));
        }
        using Corner = std::array<double, 3>;
        if (position["min"].get<Corner>() != lowest || position["max"].get<Corner>() != highest)
            throw std::runtime_error("min and max are wrong");
    }
    return out;
}

/// Faces of a PLY file as this project writes them.
inline ReadMesh read_ply(const std::string& bytes) {
    ReadMesh out;
    const std::string end = "end_header\n";
    const std::size_t body = bytes.find(end) + end.size();
    const std::string head = bytes.substr(0, body);
    const auto count = [&](const std::string& what) {
        return std::stoul(head.substr(head.find("element " + what + " ") + what.size() + 9));
    };
    out.vertices = count("vertex");
    std::size_t at = body + out.vertices * 16;
    for (std::size_t f = 0; f < count("face"); ++f) {
        ReadMesh::Face face;
        const auto corners = value_at<std::uint8_t>(bytes, at++);
        for (std::size_t k = 0; k < corners; ++k, at += 4) {
            const auto v = value_at<std::uint32_t>(bytes, at);
            if (v >= out.vertices)
                throw std::runtime_error("an index leads outside");
            const std::size_t from = body + v * 16;
            face.corners.push_back({value_at<float>(bytes, from), value_at<float>(bytes, from + 4),
                                    value_at<float>(bytes, from + 8)});
            if (k > 0)
                continue;
            for (std::size_t a = 0; a < 3; ++a)
                face.colour[a] = value_at<std::uint8_t>(bytes, from + 12 + a) / 255.0;
            face.material = std::to_string(value_at<std::uint8_t>(bytes, from + 15));
        }
        out.faces.push_back(std::move(face));
    }
    if (at != bytes.size())
        throw std::runtime_error("bytes are left");
    out.head["text"] = head;
    return out;
}

}  // namespace terravox::test
