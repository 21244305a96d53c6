// Writes orthophotos as they are and as albedo, and says which light was found: for looking at.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <fstream>
#include <string>
#include <vector>

#include "voxelserver/imagery/orthophotos.hpp"
#include "voxelserver/voxelize/points/settings.hpp"
#include "voxelserver/voxelize/steps/photo_lights.hpp"

using namespace terravox;

namespace {

struct Picture {
    int width = 0;
    int height = 0;
    std::vector<voxel::Rgb8> pixels;
    Picture(int w, int h)
        : width(w), height(h), pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h)) {}
    void put(int x, int z, const imagery::Raster& raster) {
        if (raster.empty())
            return;
        for (int j = 0; j < raster.height; ++j)
            for (int i = 0; i < raster.width; ++i)
                if (x + i < width && z + j < height)
                    pixels[static_cast<std::size_t>(z + j) * static_cast<std::size_t>(width) +
                           static_cast<std::size_t>(x + i)] =
                        raster.colour[static_cast<std::size_t>(j * raster.width + i)];
    }
    void write(const std::string& path) const {
        std::ofstream out(path, std::ios::binary);
        out << "P6\n" << width << ' ' << height << "\n255\n";
        for (const auto& p : pixels)
            out << static_cast<char>(p.r) << static_cast<char>(p.g) << static_cast<char>(p.b);
    }
};

int run(int argc, char** argv) {
    CLI::App app("orthophotos before and after");
    voxelize::LidarWorldOptions options;
    std::string output = "photo";
    std::vector<std::string> files;
    std::vector<std::string> images;
    app.add_option("files", files)->required();
    app.add_option("--orthophoto", images)->required();
    app.add_option("--classes", options.classes);
    app.add_option("--crs", options.crs);
    app.add_option("--voxel-m", options.voxel_m);
    app.add_option("-o", output);
    CLI11_PARSE(app, argc, argv);
    options.files.assign(files.begin(), files.end());
    options.orthophotos.assign(images.begin(), images.end());
    util::StageTimes times;
    const auto settings = voxelize::load_settings({}, "");
    voxelize::PointSet points(options, settings, times);
    const auto& sources = points.sources();
    const imagery::Orthophotos photos(options.orthophotos, sources.frame, sources.named_squares);
    voxelize::PhotoLights lights(photos, points, times);
    const grid::ColumnRect b = sources.bounds;
    Picture raw(b.max_x - b.min_x, b.max_z - b.min_z);
    Picture albedo = raw;
    for (int pz = b.min_z >> 6; pz <= (b.max_z - 1) >> 6; ++pz)
        for (int px = b.min_x >> 6; px <= (b.max_x - 1) >> 6; ++px) {
            const grid::PatchKey key{px, pz};
            const int x = key.x0() - b.min_x;
            const int z = key.z0() - b.min_z;
            if (x < 0 || z < 0)
                continue;
            raw.put(x, z, photos.read(key.x0(), key.z0(), 64, 64));
            albedo.put(x, z, lights.albedo(key));
        }
    raw.write(output + "_raw.ppm");
    albedo.write(output + "_albedo.ppm");
    for (std::size_t i = 0; i < photos.count(); ++i) {
        const auto found = lights.light_of(i);
        const auto& l = found.light;
        std::printf(
            "azimuth %.1f altitude %.1f correlation %.3f margin %.3f found %d sky %.2f %.2f "
            "%.2f veil %.3f %.3f %.3f gain %.2f %.2f %.2f\n",
            found.estimate.sun.azimuth_deg, found.estimate.sun.altitude_deg,
            found.estimate.correlation, found.estimate.margin, l.sun ? 1 : 0, l.sky[0], l.sky[1],
            l.sky[2], l.veil[0], l.veil[1], l.veil[2], l.gain[0], l.gain[1], l.gain[2]);
    }
    for (const auto& row : times.stages())
        std::printf("%s %.3f s\n", row.name.c_str(), row.seconds);
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    try {
        return run(argc, argv);
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
