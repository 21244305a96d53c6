#include "voxelserver/out/export/vdb/vdb.hpp"

#include <openvdb/openvdb.h>

#include "common/util/error.hpp"
#include "common/voxel/colour.hpp"
#include "tests/catch.hpp"
#include "tests/voxelserver/out/export/shape/painted_world.hpp"
#include "voxelserver/out/export/shape/placing.hpp"

using namespace terravox;
using namespace terravox::exports;
using voxel::Material;

namespace {

struct ReadVdb {
    openvdb::FloatGrid::Ptr density;
    openvdb::Int32Grid::Ptr material;
    openvdb::Vec3SGrid::Ptr colour;
};

ReadVdb read_vdb(const std::filesystem::path& path) {
    openvdb::initialize();
    openvdb::io::File file(path.string());
    file.open(false);
    return {openvdb::gridPtrCast<openvdb::FloatGrid>(file.readGrid("density")),
            openvdb::gridPtrCast<openvdb::Int32Grid>(file.readGrid("material")),
            openvdb::gridPtrCast<openvdb::Vec3SGrid>(file.readGrid("Cd"))};
}

// How many voxels of the part differ from what is found at their places, by metres, in one of the
// files.
std::size_t differences(const test::PaintedWorld& world, const Job& job,
                        const std::vector<ReadVdb>& files, UpAxis up) {
    std::size_t out = 0;
    const auto& b = job.part.bounds;
    const auto o = make_origin(job.part);
    for (int y = b.min[1]; y < b.max[1]; ++y)
        for (int z = b.min[2]; z < b.max[2]; ++z)
            for (int x = b.min[0]; x < b.max[0]; ++x) {
                const double e = (x + 0.5 - o[0]) * 0.5;
                const double h = (y + 0.5 - o[1]) * 0.5;
                const double s = (z + 0.5 - o[2]) * 0.5;
                const openvdb::Vec3d at =
                    up == UpAxis::kY ? openvdb::Vec3d(e, h, s) : openvdb::Vec3d(e, -s, h);
                const bool solid = world.at(x, y, z) != Material::kAir;
                const bool seen = solid && !world.hidden(x, y, z);
                const auto attr = world.attr_at(x, y, z);
                const voxel::Rgb8 c = job.to_colour(attr);
                std::size_t found = 0;
                for (const ReadVdb& f : files) {
                    const auto i = f.density->transform().worldToIndexCellCentered(at);
                    if (!f.density->tree().isValueOn(i)) {
                        out += f.density->tree().getValue(i) != 0 ||
                               f.material->tree().isValueOn(i) || f.colour->tree().isValueOn(i);
                        continue;
                    }
                    ++found;
                    out += f.density->tree().getValue(i) != 1 ||
                           f.material->tree().getValue(i) != static_cast<int>(attr.material) ||
                           f.colour->tree().isValueOn(i) != seen;
                    const openvdb::Vec3s wanted(voxel::srgb_to_linear(c.r),
                                                voxel::srgb_to_linear(c.g),
                                                voxel::srgb_to_linear(c.b));
                    out += seen && f.colour->tree().getValue(i) != wanted;
                }
                out += found != (solid ? 1u : 0u);
            }
    return out;
}

std::size_t solid_voxels(const test::PaintedWorld& world, const voxel::VoxelBounds& b) {
    std::size_t out = 0;
    for (int y = b.min[1]; y < b.max[1]; ++y)
        for (int z = b.min[2]; z < b.max[2]; ++z)
            for (int x = b.min[0]; x < b.max[0]; ++x)
                out += world.at(x, y, z) != Material::kAir;
    return out;
}

}  // namespace

TEST_CASE("a vdb file holds every voxel, at its place in metres", "[convert][vdb]") {
    struct Case {
        const char* name;
        UpAxis up;
        voxel::VoxelBounds bounds;
    };
    const voxel::VoxelBounds all{{-70, -12, -9}, {75, 300, 80}};
    const auto c = GENERATE_COPY(values<Case>({
        {"y up", UpAxis::kY, all},
        {"a part, z up", UpAxis::kZ, {{-33, -7, 2}, {66, 259, 71}}},
    }));
    DYNAMIC_SECTION(c.name) {
        const auto world = test::lumps(31, 1000);
        test::ExportJob e(*world, c.bounds, "a.vdb");
        write_vdb(e.job, {c.up});
        CHECK(test::files_in(e.folder.path()) ==
              std::set<std::string>{"a.vdb", "a.vdb.georef.json"});
        const ReadVdb file = read_vdb(e.job.out);
        const std::size_t solid = solid_voxels(*world, c.bounds);
        CHECK(e.job.voxels() == solid);
        CHECK(file.density->activeVoxelCount() == solid);
        CHECK(file.material->activeVoxelCount() == solid);
        CHECK(differences(*world, e.job, {file}, c.up) == 0);
        CHECK(file.density->getGridClass() == openvdb::GRID_FOG_VOLUME);
        CHECK(file.density->metaValue<std::string>("crs") == "EPSG:3794");
        CHECK(file.colour->metaValue<std::string>("attribution") == "nobody");
    }
}

TEST_CASE("hidden rock costs next to nothing in a vdb file", "[convert][vdb]") {
    test::PaintedWorld world({0, 0, 0}, {128, 256, 64}, 0);
    world.fill({0, 0, 0}, {128, 256, 64}, Material::kRock);
    test::ExportJob e(world, "a.vdb");
    write_vdb(e.job);
    const ReadVdb file = read_vdb(e.job.out);
    CHECK(file.density->activeVoxelCount() == 128u * 256 * 64);
    CHECK(file.density->tree().leafCount() == 0);  // one value throughout: tiles
    CHECK(file.colour->tree().leafCount() > 0);
    CHECK(file.colour->activeVoxelCount() == 128u * 256 * 64 - 126u * 254 * 62);
}

TEST_CASE("where memory is scarce there are several vdb files that fit together",
          "[convert][vdb]") {
    const auto world = test::lumps(32, 9);
    test::ExportJob e(*world, {{-70, -12, -9}, {75, 60, 80}}, "town.vdb");
    e.job.memory_bytes = GENERATE(std::size_t{0}, std::size_t{3} << 20);
    write_vdb(e.job);
    std::vector<ReadVdb> files;
    const auto names = test::files_in(e.folder.path());
    for (const auto& name : names)
        if (name.ends_with(".vdb"))
            files.push_back(read_vdb(e.folder.path() / name));
    INFO(e.job.memory_bytes);
    CHECK(files.size() * 2 == names.size());
    CHECK((files.size() > 1 && files.size() <= 12));
    CHECK(!names.contains("town.vdb"));
    CHECK(names.contains("town_0_0.vdb"));
    CHECK(differences(*world, e.job, files, UpAxis::kZ) == 0);
    CHECK(e.job.voxels() == solid_voxels(*world, e.job.part.bounds));
}
