#include "voxelserver/out/export/mesh/mesh.hpp"

#include <algorithm>
#include <tuple>

#include "common/util/error.hpp"
#include "common/voxel/colour.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/out/export/mesh/read_mesh.hpp"
#include "tests/voxelserver/out/export/shape/painted_world.hpp"
#include "voxelserver/out/export/shape/placing.hpp"

using namespace terravox;
using namespace terravox::exports;
using test::PaintedWorld;
using voxel::Material;

namespace {

// A face: the voxel it belongs to, which way it looks (0 to 5: -x, +x, -y, +y, -z, +z), and its
// attributes.
using Face = std::tuple<int, int, int, int, FaceAttributes>;
constexpr int kSteps[6][3] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}};

// The rule once more, voxel by voxel.
std::vector<Face> list_faces(const PaintedWorld& world, const Part& part, const Job& job) {
    std::vector<Face> out;
    const auto material = [&](int x, int y, int z) {
        return part.holds(x, y, z) ? world.at(x, y, z) : Material::kAir;
    };
    for (int y = part.bounds.min[1]; y < part.bounds.max[1]; ++y)
        for (int z = part.bounds.min[2]; z < part.bounds.max[2]; ++z)
            for (int x = part.bounds.min[0]; x < part.bounds.max[0]; ++x) {
                if (material(x, y, z) == Material::kAir)
                    continue;
                const auto attr = world.attr_at(x, y, z);
                for (int d = 0; d < 6; ++d) {
                    const Material neighbour =
                        material(x + kSteps[d][0], y + kSteps[d][1], z + kSteps[d][2]);
                    if (!voxel::see_through(neighbour) ||
                        (neighbour == material(x, y, z) && neighbour != Material::kAir))
                        continue;
                    out.emplace_back(x, y, z, d, to_attributes(attr.material, job.to_colour(attr)));
                }
            }
    std::sort(out.begin(), out.end());
    return out;
}

// Unit faces of quads with corners in voxels of the world, after which way they wind.
void split(const std::array<std::array<int, 3>, 4>& c, FaceAttributes attributes,
           std::vector<Face>& out) {
    std::array<int, 3> lo = c[0];
    std::array<int, 3> hi = c[0];
    std::array<int, 3> n{};
    for (const auto& p : c)
        for (std::size_t a = 0; a < 3; ++a) {
            lo[a] = std::min(lo[a], p[a]);
            hi[a] = std::max(hi[a], p[a]);
        }
    for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t b = (a + 1) % 3;
        const std::size_t e = (a + 2) % 3;
        n[a] =
            (c[1][b] - c[0][b]) * (c[2][e] - c[0][e]) - (c[1][e] - c[0][e]) * (c[2][b] - c[0][b]);
    }
    const std::size_t axis = n[0] != 0 ? 0 : n[1] != 0 ? 1 : 2;
    REQUIRE(lo[axis] == hi[axis]);
    const int d = static_cast<int>(axis) * 2 + (n[axis] > 0 ? 1 : 0);
    hi[axis] = lo[axis] + 1;
    for (int y = lo[1]; y < hi[1]; ++y)
        for (int z = lo[2]; z < hi[2]; ++z)
            for (int x = lo[0]; x < hi[0]; ++x)
                out.emplace_back(x - (d == 1), y - (d == 3), z - (d == 5), d, attributes);
}

std::vector<Face> list_faces(const ColumnMesh& mesh, const std::array<std::int32_t, 3>& origin) {
    std::vector<Face> out;
    for (const auto& [material, part] : mesh.parts)
        for (const auto& q : part.quads) {
            std::array<std::array<int, 3>, 4> corners{};
            for (std::size_t i = 0; i < 4; ++i)
                for (std::size_t a = 0; a < 3; ++a)
                    corners[i][a] = part.vertices[q[i]].at[a] + origin[a];
            for (const auto i : q)
                REQUIRE(part.vertices[i].attributes == part.vertices[q[0]].attributes);
            REQUIRE(to_material(part.vertices[q[0]].attributes) == material);
            split(corners, part.vertices[q[0]].attributes, out);
        }
    return out;
}

}  // namespace

TEST_CASE("every exposed face is covered once and nothing else is", "[convert][mesh]") {
    struct Case {
        const char* name;
        unsigned seed;
        std::uint32_t colours;
        bool merge;
        voxel::VoxelBounds bounds;
    };
    const voxel::VoxelBounds all{{-70, -12, -9}, {75, 300, 80}};
    const auto c = GENERATE_COPY(values<Case>({
        {"all of it, three colours", 2, 3, true, all},
        {"nothing merged", 4, 3, false, {{-33, -7, 2}, {66, 59, 71}}},
        {"a part, cut through boxes, many colours", 5, 1000, true, {{-33, -7, 2}, {66, 259, 71}}},
        {"a part that ends with boxes", 7, 0, true, {{-64, 0, 0}, {64, 256, 64}}},
    }));
    DYNAMIC_SECTION(c.name << ", seed " << c.seed) {
        const auto world = test::lumps(c.seed, c.colours);
        test::ExportJob e(*world, c.bounds, "a.glb");
        MeshOptions options;
        options.merge = c.merge;
        ColumnMesher mesher(e.job, options);
        const auto range = e.job.part.boxes();
        std::vector<Face> found;
        std::size_t quads = 0;
        for (int bz = range.min.bz; bz < range.max.bz; ++bz)
            for (int bx = range.min.bx; bx < range.max.bx; ++bx) {
                const ColumnMesh mesh = mesher.make(bx, bz);
                for (const auto& [material, part] : mesh.parts)
                    quads += part.quads.size();
                const auto faces = list_faces(mesh, make_origin(e.job.part));
                found.insert(found.end(), faces.begin(), faces.end());
            }
        std::sort(found.begin(), found.end());
        const auto wanted = list_faces(*world, e.job.part, e.job);
        REQUIRE(wanted.size() > 1000);
        CHECK(found.size() == wanted.size());
        CHECK(std::adjacent_find(found.begin(), found.end()) == found.end());
        CHECK(found == wanted);
        if (c.merge)
            CHECK(quads < wanted.size());
        else
            CHECK(quads == wanted.size());
    }
}

TEST_CASE("a wall of one colour is one quad in each box, and one colour more is three",
          "[convert][mesh]") {
    PaintedWorld world({0, 0, 0}, {64, 64, 64}, 0);
    world.fill({0, 0, 0}, {64, 64, 64}, Material::kWall);
    test::ExportJob e(world, "a.glb");
    ColumnMesher mesher(e.job, {});
    CHECK(mesher.make(0, 0).parts.at(Material::kWall).quads.size() == 6);
    CHECK(mesher.make(0, 0).parts.at(Material::kWall).vertices.size() == 8);
    world.set(0, 63, 0, Material::kRoof);
    test::ExportJob f(world, "a.glb");
    ColumnMesher again(f.job, {});
    const auto mesh = again.make(0, 0);
    CHECK(mesh.parts.at(Material::kRoof).quads.size() == 3);
    CHECK(mesh.parts.at(Material::kWall).quads.size() == 9);
}

TEST_CASE("mesh files enclose what is solid, at its place, in its colours", "[convert][mesh]") {
    const auto format = GENERATE(MeshFormat::kGlb, MeshFormat::kPly);
    const bool glb = format == MeshFormat::kGlb;
    const auto world = test::lumps(11, 4, false);
    test::ExportJob e(*world, glb ? "a.glb" : "a.ply");
    write_mesh(e.job, format);
    const std::string bytes = test::read_content(e.job.out);
    const auto mesh = glb ? test::read_glb(bytes) : test::read_ply(bytes);
    const auto wanted = list_faces(*world, e.job.part, e.job);
    std::size_t solid = 0;
    std::size_t seen = 0;
    const auto& b = e.job.part.bounds;
    for (int y = b.min[1]; y < b.max[1]; ++y)
        for (int z = b.min[2]; z < b.max[2]; ++z)
            for (int x = b.min[0]; x < b.max[0]; ++x) {
                if (world->at(x, y, z) == Material::kAir)
                    continue;
                ++solid;
                if (!world->hidden(x, y, z))
                    ++seen;
            }
    constexpr double kArea = 0.25, kVolume = 0.125;  // voxels of 0.5 m
    CHECK(mesh.area() == Approx(static_cast<double>(wanted.size()) * kArea).epsilon(1e-9));
    CHECK(mesh.volume() == Approx(static_cast<double>(solid) * kVolume).epsilon(1e-9));
    CHECK(e.job.voxels() == seen);
    CHECK(mesh.vertices < mesh.faces.size() * 4);

    // Each face looks like the voxel behind it.
    const auto o = make_origin(e.job.part);
    std::size_t wrong = 0;
    for (const auto& face : mesh.faces) {
        const auto n = test::ReadMesh::normal(face);
        const double length = std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]);
        std::array<double, 3> p{};
        for (std::size_t a = 0; a < 3; ++a) {
            for (const auto& corner : face.corners)
                p[a] += corner[a] / static_cast<double>(face.corners.size());
            p[a] = (p[a] - 0.1 * n[a] / length) / 0.5;
        }
        const std::array<double, 3> q = glb ? p : std::array<double, 3>{p[0], p[2], -p[1]};
        const auto attr = world->attr_at(static_cast<int>(std::floor(q[0])) + o[0],
                                         static_cast<int>(std::floor(q[1])) + o[1],
                                         static_cast<int>(std::floor(q[2])) + o[2]);
        const voxel::Rgb8 c = e.job.to_colour(attr);
        const std::array<double, 3> colour =
            glb ? std::array<double, 3>{voxel::srgb_to_linear(c.r), voxel::srgb_to_linear(c.g),
                                        voxel::srgb_to_linear(c.b)}
                : std::array<double, 3>{c.r / 255.0, c.g / 255.0, c.b / 255.0};
        for (std::size_t a = 0; a < 3; ++a)
            wrong += std::abs(colour[a] - face.colour[a]) > 1e-5;
        wrong += face.material != (glb ? std::string(voxel::material_name(attr.material))
                                       : std::to_string(static_cast<int>(attr.material)));
    }
    CHECK(wrong == 0);
    CHECK(test::files_in(e.folder.path()).size() == 2);  // and the side-car
}

TEST_CASE("a part of a coarser level has larger voxels", "[convert][mesh]") {
    test::ArrayWorld world({-3, 5, -70}, {4, 9, -60}, 2);
    world.fill({-3, 5, -70}, {4, 9, -60}, Material::kMasonry);
    test::ExportJob e(world, world.level_bounds(), "a.ply", 2);
    write_mesh(e.job, MeshFormat::kPly);
    const auto mesh = test::read_ply(test::read_content(e.job.out));
    CHECK(mesh.volume() == Approx(7 * 4 * 10 * 64.0));
    CHECK(mesh.area() == Approx(2 * (7 * 4 + 7 * 10 + 4 * 10) * 16.0));
    std::array<double, 3> low{1e9, 1e9, 1e9};
    for (const auto& face : mesh.faces)
        for (const auto& corner : face.corners)
            for (std::size_t a = 0; a < 3; ++a)
                low[a] = std::min(low[a], corner[a]);
    // The middle is at x = 0, z = -65, y = 5 voxels of 4 m.
    CHECK(low == std::array<double, 3>{-12, -20, 0});
}

TEST_CASE("water, glass and lamps have materials that show it", "[convert][mesh]") {
    const auto world = test::lumps(12, 0);
    test::ExportJob e(*world, "a.glb");
    write_mesh(e.job, MeshFormat::kGlb);
    const auto head = test::read_glb(test::read_content(e.job.out)).head;
    std::map<std::string, nlohmann::json> of;
    for (const auto& m : head["materials"])
        of[m["name"]] = m;
    CHECK(of.at("water")["alphaMode"] == "BLEND");
    CHECK(of.at("glass")["pbrMetallicRoughness"]["baseColorFactor"][3] == 0.25);
    CHECK(of.at("lamp")["emissiveFactor"][0] > 0.5);
    CHECK(!of.at("rock").contains("alphaMode"));
    CHECK(head["nodes"][0]["extras"]["crs"] == "EPSG:3794");
    CHECK(head["nodes"][0]["extras"]["offset"] == nlohmann::json(make_origin(e.job.part)));
    CHECK(head["asset"]["copyright"] == "nobody");
}

TEST_CASE("fewer steps of colours make fewer faces", "[convert][mesh]") {
    const auto world = test::lumps(14, 100000);
    const auto faces_with = [&](int steps) {
        test::ExportJob e(*world, {{-33, -7, 2}, {66, 59, 71}}, "a.ply");
        MeshOptions options;
        options.colour_steps = steps;
        write_mesh(e.job, MeshFormat::kPly, options);
        const auto mesh = test::read_ply(test::read_content(e.job.out));
        std::set<double> values;
        for (const auto& face : mesh.faces)
            values.insert(face.colour.begin(), face.colour.end());
        if (steps > 0)
            CHECK(values.size() <= static_cast<std::size_t>(steps));
        if (steps == 2)
            CHECK(values == std::set<double>{0, 1});
        return mesh.faces.size();
    };
    const std::size_t all = faces_with(0);
    const std::size_t sixteen = faces_with(16);
    const std::size_t two = faces_with(2);
    CHECK(sixteen <= all);
    CHECK(two < sixteen);
    test::ExportJob e(*world, "a.ply");
    MeshOptions options;
    options.colour_steps = 1;
    CHECK_THROWS_AS(write_mesh(e.job, MeshFormat::kPly, options), util::UsageError);
}

TEST_CASE("a mesh that would be too large leaves nothing behind", "[convert][mesh]") {
    const auto world = test::lumps(15, 0);
    test::ExportJob e(*world, "a.glb");
    MeshOptions options;
    options.max_glb_bytes = 100000;
    CHECK_THROWS_WITH(write_mesh(e.job, MeshFormat::kGlb, options),
                      test::contains("more than 100000 bytes"));
    CHECK(test::files_in(e.folder.path()).empty());
}
