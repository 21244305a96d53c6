// Writes a synthetic lump of voxels in all shapes, with the numbers that readers of other makers
// must find in them: for tests/bench/export.
//   export_shapes FOLDER [EDGE LAZ...]
// With survey files: the same of the middle of their world, EDGE voxels wide and deep, without the
// truth; an orthophoto is searched for in ortho/ next to the first.
#include <spdlog/spdlog.h>

#include <chrono>
#include <iostream>
#include <nlohmann/json.hpp>

#include "common/util/atomic_file.hpp"
#include "common/util/config_dir.hpp"
#include "common/util/error.hpp"
#include "common/util/stage_times.hpp"
#include "tests/voxelserver/export/shape/painted_world.hpp"
#include "voxelserver/export/mesh/mesh.hpp"
#include "voxelserver/export/vdb/vdb.hpp"
#include "voxelserver/export/vox/vox.hpp"
#include "voxelserver/voxelize/world/lidar_world.hpp"

namespace {

using namespace terravox;
using namespace terravox::exports;
using nlohmann::json;

json counts_of(const test::PaintedWorld& world) {
    std::uint64_t solid = 0;
    std::uint64_t seen = 0;
    std::uint64_t faces = 0;
    const auto& b = world.level_bounds();
    for (int y = b.min[1]; y < b.max[1]; ++y)
        for (int z = b.min[2]; z < b.max[2]; ++z)
            for (int x = b.min[0]; x < b.max[0]; ++x) {
                const auto own = world.at(x, y, z);
                if (own == voxel::Material::kAir)
                    continue;
                ++solid;
                seen += !world.hidden(x, y, z);
                for (const auto beside :
                     {world.at(x - 1, y, z), world.at(x + 1, y, z), world.at(x, y - 1, z),
                      world.at(x, y + 1, z), world.at(x, y, z - 1), world.at(x, y, z + 1)})
                    faces += beside == voxel::Material::kAir ||
                             (voxel::see_through(beside) && beside != own);
            }
    return {{"solid", solid}, {"seen", seen}, {"faces", faces}};
}

template <class Write>
json export_one(voxel::World& world, const voxel::VoxelBounds& bounds,
                const std::filesystem::path& file, const Write& write) {
    const auto palette = voxel::load_palette(util::config_dir() / "materials.toml");
    Meter meter(file.filename().string(), 1, true);
    Job job(world, {0, bounds}, file, palette, meter);
    const auto start = std::chrono::steady_clock::now();
    write(job);
    const double seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    json files = json::array();
    for (const auto& f : job.files())
        files.push_back(f.filename().string());
    return {{"voxels", job.voxels()},
            {"files", files},
            {"bytes", std::filesystem::file_size(job.files().front())},
            {"seconds", seconds},
            {"holes", job.holes().size()}};
}

json export_all(voxel::World& world, const voxel::VoxelBounds& bounds,
                const std::filesystem::path& folder, const std::string& name) {
    const auto mesh = [&](const std::string& ending, MeshFormat format, const MeshOptions& options,
                          Colours colours) {
        return export_one(world, bounds, folder / (name + ending), [&](Job& job) {
            job.colours = colours;
            write_mesh(job, format, options);
        });
    };
    MeshOptions single;
    MeshOptions coarse;
    single.merge = false;
    coarse.colour_steps = 16;
    json out;
    out["vox"] =
        export_one(world, bounds, folder / (name + ".vox"), [](Job& job) { write_vox(job); });
    out["vdb"] =
        export_one(world, bounds, folder / (name + ".vdb"), [](Job& job) { write_vdb(job); });
    out["glb"] = mesh(".glb", MeshFormat::kGlb, {}, Colours::kTrue);
    out["ply"] = mesh(".ply", MeshFormat::kPly, {}, Colours::kTrue);
    out["steps_glb"] = mesh("_steps.glb", MeshFormat::kGlb, coarse, Colours::kTrue);
    out["materials_glb"] = mesh("_materials.glb", MeshFormat::kGlb, {}, Colours::kMaterial);
    out["single_ply"] = mesh("_single.ply", MeshFormat::kPly, single, Colours::kMaterial);
    out["voxel_m"] = world.info().voxel_m;
    return out;
}

void run(int argc, char** argv) {
    if (argc < 2 || argc == 3)
        throw util::UsageError("export_shapes FOLDER [EDGE LAZ...]");
    const std::filesystem::path folder = argv[1];
    json out = json::object();
    if (argc == 2) {
        for (const bool see_through : {false, true}) {
            const auto world = test::lumps(41, 40, see_through);
            const std::string name = see_through ? "clear" : "solid";
            out[name] = export_all(*world, world->info().bounds, folder, name);
            out[name]["truth"] = counts_of(*world);
        }
        test::PaintedWorld ball({-40, 60, -40}, {40, 140, 40}, 0);
        ball.fill_with([](int x, int y, int z) {
            return x * x + (y - 100) * (y - 100) + z * z < 35 * 35 ? voxel::Material::kMasonry
                                                                   : voxel::Material::kAir;
        });
        out["ball"] = export_all(ball, ball.info().bounds, folder, "ball");
        out["ball"]["truth"] = counts_of(ball);
    } else {
        voxelize::LidarWorldOptions options;
        for (int i = 3; i < argc; ++i)
            options.files.emplace_back(argv[i]);
        options.orthophotos = {std::filesystem::path(argv[3]).parent_path() / "ortho"};
        if (!std::filesystem::exists(options.orthophotos[0]))
            options.orthophotos.clear();
        util::StageTimes times;
        const auto world = voxelize::open_lidar_world(options, times);
        auto bounds = world->info().bounds;
        const int half = std::stoi(argv[2]) / 2;
        for (const std::size_t a : {0u, 2u}) {
            const int middle = (bounds.min[a] + bounds.max[a]) / 2;
            bounds.min[a] = std::max(bounds.min[a], middle - half);
            bounds.max[a] = std::min(bounds.max[a], middle + half);
        }
        out["survey"] = export_all(*world, bounds, folder, "survey");
    }
    util::write_file_atomically(folder / "numbers.json", out.dump(1) + "\n");
    std::cout << out.dump(1) << '\n';
}

}  // namespace

int main(int argc, char** argv) {
    try {
        run(argc, argv);
    } catch (const std::exception& e) {
        std::cerr << e.what() << '\n';
        return 1;
    }
    return 0;
}
