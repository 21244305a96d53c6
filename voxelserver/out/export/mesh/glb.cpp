#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "common/util/error.hpp"
#include "common/util/version.hpp"
#include "common/voxel/colour.hpp"
#include "voxelserver/out/export/mesh/mesh.hpp"
#include "voxelserver/out/export/shape/placing.hpp"

namespace terravox::exports {
namespace {

using nlohmann::json;
using voxel::Material;

struct GlbVertex {
    std::array<float, 3> at;
    std::array<std::uint16_t, 4> colour;  ///< linear; 8 bits would not distinguish dark colours
};
static_assert(sizeof(GlbVertex) == 20);

constexpr std::uint32_t kMagic = 0x46546C67;
constexpr std::uint32_t kJsonChunk = 0x4E4F534A;
constexpr std::uint32_t kBinChunk = 0x004E4942;
constexpr int kArrayBuffer = 34962;
constexpr int kElementArrayBuffer = 34963;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;
constexpr std::uint64_t kHeadBytes = 64 << 10;  // more than the JSON text takes

std::uint16_t linear_16(std::uint8_t srgb) noexcept {
    return static_cast<std::uint16_t>(voxel::srgb_to_linear(srgb) * 65535.f + 0.5f);
}

struct Transparency {
    double alpha;
    double roughness;
};
std::optional<Transparency> find_transparency(Material m) noexcept {
    switch (voxel::find_traits(m).optics) {
        case voxel::Optics::kWater: return Transparency{0.75, 0.05};
        case voxel::Optics::kGlass: return Transparency{0.25, 0.05};
        case voxel::Optics::kIce: return Transparency{0.7, 0.1};
        default: return std::nullopt;
    }
}

// Colours come from the vertices; the material defines the optics. Leaves are opaque: there is no
// texture with holes.
json material_json(Material m, const voxel::Palette& palette) {
    const auto clear = find_transparency(m);
    json out = {{"name", std::string(voxel::material_name(m))},
                {"pbrMetallicRoughness",
                 {{"baseColorFactor", {1, 1, 1, clear ? clear->alpha : 1}},
                  {"metallicFactor", 0},
                  {"roughnessFactor", clear ? clear->roughness : 1}}}};
    if (clear)
        out["alphaMode"] = "BLEND";
    if (voxel::find_traits(m).glow > 0) {
        const voxel::Rgb8 c = palette.of(m).colour;
        out["emissiveFactor"] = {voxel::srgb_to_linear(c.r), voxel::srgb_to_linear(c.g),
                                 voxel::srgb_to_linear(c.b)};
    }
    return out;
}

/// All faces of one material: a primitive.
struct Primitive {
    explicit Primitive(const std::filesystem::path& target)
        : vertices(ByteFile::spool_for(target)), indices(ByteFile::spool_for(target)) {}
    ByteFile vertices;
    ByteFile indices;
    std::uint64_t vertex_count = 0;
    std::uint64_t index_count = 0;
    std::array<float, 3> min;
    std::array<float, 3> max;
};

/// Ref: Khronos Group, "glTF 2.0 Specification", 2021, also ISO/IEC 12113:2022.
class GlbWriter : public MeshWriter {
public:
    GlbWriter(const Job& job, const MeshOptions& options)
        : m_job(job),
          m_max_bytes(std::min<std::uint64_t>(options.max_glb_bytes,
                                              std::numeric_limits<std::uint32_t>::max())) {}

    void add(const ColumnMesh& mesh) override {
        for (const auto& [material, part] : mesh.parts) {
            m_bytes += part.vertices.size() * sizeof(GlbVertex) +
                       part.quads.size() * 6 * sizeof(std::uint32_t);
            if (m_bytes + kHeadBytes > m_max_bytes)
                throw util::Error("write " + m_job.out.string() + ": more than " +
                                  std::to_string(m_max_bytes) +
                                  " bytes, the most that a glTF file can have; nothing was written "
                                  "(smaller: a part, a coarser level, fewer steps of colours, " +
                                  "the colours of materials)");
            add(part, m_parts.try_emplace(material, m_job.out).first->second);
        }
    }

    [[nodiscard]] bool empty() const noexcept override { return m_parts.empty(); }

    void finish(ByteFile& to) override {
        std::string text = head().dump(-1, ' ', false, json::error_handler_t::replace);
        text.append((4 - text.size() % 4) % 4, ' ');
        const std::uint64_t total = 12 + 8 + text.size() + 8 + m_bytes;
        if (total > m_max_bytes)
            throw util::Error("write " + m_job.out.string() + ": " + std::to_string(total) +
                              " bytes; allowed: up to " + std::to_string(m_max_bytes));
        for (const std::uint32_t word : {kMagic, 2u, static_cast<std::uint32_t>(total),
                                         static_cast<std::uint32_t>(text.size()), kJsonChunk})
            to.put_value(word);
        to.put(text);
        for (const std::uint32_t word : {static_cast<std::uint32_t>(m_bytes), kBinChunk})
            to.put_value(word);
        for (auto& [material, part] : m_parts) {
            part.vertices.copy_to(to);
            part.indices.copy_to(to);
        }
    }

private:
    void add(const IndexedQuads& from, Primitive& to) const {
        const double voxel_m = m_job.voxel_m();
        const auto first = static_cast<std::uint32_t>(to.vertex_count);
        std::vector<GlbVertex> vertices;
        vertices.reserve(from.vertices.size());
        for (const MeshVertex& v : from.vertices) {
            const voxel::Rgb8 c = to_colour(v.attributes);
            GlbVertex out{{}, {linear_16(c.r), linear_16(c.g), linear_16(c.b), 65535}};
            for (std::size_t a = 0; a < 3; ++a)
                out.at[a] = static_cast<float>(v.at[a] * voxel_m);
            if (to.vertex_count == 0 && vertices.empty())
                to.min = to.max = out.at;
            for (std::size_t a = 0; a < 3; ++a) {
                to.min[a] = std::min(to.min[a], out.at[a]);
                to.max[a] = std::max(to.max[a], out.at[a]);
            }
            vertices.push_back(out);
        }
        std::vector<std::uint32_t> indices;
        indices.reserve(from.quads.size() * 6);
        for (const auto& q : from.quads)
            for (const std::size_t corner : {0u, 1u, 2u, 0u, 2u, 3u})
                indices.push_back(first + q[corner]);
        to.vertices.put(std::as_bytes(std::span(vertices)));
        to.indices.put(std::as_bytes(std::span(indices)));
        to.vertex_count += vertices.size();
        to.index_count += indices.size();
    }

    /// The arrays of the JSON text that grow with each primitive.
    struct Tables {
        json views = json::array();
        json accessors = json::array();
        json primitives = json::array();
        json materials = json::array();
        std::uint64_t offset = 0;  ///< of the next primitive in the binary chunk
    };

    [[nodiscard]] json head() const {
        Tables tables;
        for (const auto& [material, part] : m_parts)
            add_tables(material, part, tables);
        const std::string title = m_job.world().title.empty() ? "terravox" : m_job.world().title;
        json out = json::object();
        out["asset"] = asset_json();
        out["scene"] = 0;
        out["scenes"] = json::array({json::object({{"nodes", json::array({0})}})});
        out["nodes"] =
            json::array({json::object({{"mesh", 0}, {"name", title}, {"extras", extras_json()}})});
        out["meshes"] =
            json::array({json::object({{"name", title}, {"primitives", tables.primitives}})});
        out["materials"] = tables.materials;
        out["accessors"] = tables.accessors;
        out["bufferViews"] = tables.views;
        out["buffers"] = json::array({json::object({{"byteLength", m_bytes}})});
        return out;
    }

    void add_tables(Material material, const Primitive& part, Tables& to) const {
        const std::size_t view = to.views.size();
        const std::size_t accessor = to.accessors.size();
        add_views(part, to);
        add_accessors(part, view, to.accessors);
        // Without normals: a viewer then has to shade flat, and faces can share vertices.
        to.primitives.push_back(
            {{"attributes", {{"POSITION", accessor}, {"COLOR_0", accessor + 1}}},
             {"indices", accessor + 2},
             {"material", to.materials.size()},
             {"mode", 4}});
        to.materials.push_back(material_json(material, m_job.palette));
    }

    /// Adds two buffer views: the vertices, and the indices behind them.
    static void add_views(const Primitive& part, Tables& to) {
        to.views.push_back({{"buffer", 0},
                            {"byteOffset", to.offset},
                            {"byteLength", part.vertices.bytes()},
                            {"byteStride", sizeof(GlbVertex)},
                            {"target", kArrayBuffer}});
        to.views.push_back({{"buffer", 0},
                            {"byteOffset", to.offset + part.vertices.bytes()},
                            {"byteLength", part.indices.bytes()},
                            {"target", kElementArrayBuffer}});
        to.offset += part.vertices.bytes() + part.indices.bytes();
    }

    /// Adds three accessors: positions, colours and indices.
    /// @param view the buffer view of the vertices
    static void add_accessors(const Primitive& part, std::size_t view, json& to) {
        to.push_back({{"bufferView", view},
                      {"byteOffset", 0},
                      {"componentType", kFloat},
                      {"count", part.vertex_count},
                      {"type", "VEC3"},
                      {"min", part.min},
                      {"max", part.max}});
        to.push_back({{"bufferView", view},
                      {"byteOffset", 12},
                      {"componentType", kUnsignedShort},
                      {"normalized", true},
                      {"count", part.vertex_count},
                      {"type", "VEC4"}});
        to.push_back({{"bufferView", view + 1},
                      {"byteOffset", 0},
                      {"componentType", kUnsignedInt},
                      {"count", part.index_count},
                      {"type", "SCALAR"}});
    }

    [[nodiscard]] json asset_json() const {
        json out = {{"version", "2.0"}, {"generator", std::string("terravox ") + kVersion}};
        if (!m_job.world().attribution.empty())
            out["copyright"] = m_job.world().attribution;
        return out;
    }

    [[nodiscard]] json extras_json() const {
        json out = json::object();
        for (const auto& [name, value] : collect_facts(m_job, "x east, y up, z south; metres"))
            out[name] = value;
        out["offset"] = make_origin(m_job.part);
        out["voxel_m"] = m_job.voxel_m();
        return out;
    }

    const Job& m_job;
    const std::uint64_t m_max_bytes;
    std::map<Material, Primitive> m_parts;
    std::uint64_t m_bytes = 0;  ///< of all vertices and indices
};

}  // namespace

std::unique_ptr<MeshWriter> make_glb_writer(const Job& job, const MeshOptions& options) {
    return std::make_unique<GlbWriter>(job, options);
}

}  // namespace terravox::exports
