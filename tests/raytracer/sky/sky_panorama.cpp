// Writes a sheet of skies to look at: sky_panorama FOLDER [width of a panorama in pixels]
// One picture for each altitude of the sun; in it, turbidity 2, 3 and 6 side by side, without
// clouds above and with them below. The sun stands in the middle (south); east is left. Exposed as
// a photographer would.
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>
#include <vector>

#include "common/png/png.hpp"
#include "common/util/atomic_file.hpp"
#include "raytracer/sky/sky.hpp"
#include "raytracer/sky/spectrum.hpp"

using namespace terravox;

namespace {

constexpr double kLowest_deg = -15;

struct Sheet {
    int width;
    int height;
    std::vector<std::uint8_t> pixels;
    Sheet(int w, int h)
        : width(w),
          height(h),
          pixels(static_cast<std::size_t>(w) * static_cast<std::size_t>(h) * 3) {}
    void set(int x, int y, voxel::Colour c) {
        std::uint8_t* p =
            &pixels[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                         static_cast<std::size_t>(x))];
        const auto byte = [](float v) {
            return static_cast<std::uint8_t>(
                voxel::linear_to_srgb(1 - static_cast<float>(det::exp(-static_cast<double>(v)))) *
                    255 +
                0.5f);
        };
        p[0] = byte(c.r);
        p[1] = byte(c.g);
        p[2] = byte(c.b);
    }
};

void draw(Sheet& sheet, int left, int top, int width, int height, const sky::Sky& sky) {
    constexpr double kRad = det::kPi / 180;
    constexpr int kFine = 2;
    // A night picture should look dark, so the exposure compensates only in part.
    const float exposure =
        0.7f / (voxel::luminance(sky.ambient({0, 1, 0}) +
                                 sky.sun_light() *
                                     static_cast<float>(0.3 * std::max(0.0, sky.to_sun().y))) +
                1e-4f);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            voxel::Colour sum;
            for (int i = 0; i < kFine * kFine; ++i) {
                const double azimuth = (x + (i % kFine + 0.5) / kFine) / width * 360 * kRad;
                const double altitude =
                    (90 - (y + (i / kFine + 0.5) / kFine) / height * (90 - kLowest_deg)) * kRad;
                const auto a = det::sin_cos(azimuth);
                const auto e = det::sin_cos(altitude);
                const core::Vec3 d = core::normalized({a.sin * e.cos, e.sin, -a.cos * e.cos});
                sum = sum + (sky.radiance(d) + sky.sun_disc(d)) * (exposure / (kFine * kFine));
            }
            sheet.set(left + x, top + y, sum);
        }
}

}  // namespace

int main(int argc, char** argv) {
    if (argc < 2)
        return std::fprintf(stderr, "sky_panorama FOLDER [WIDTH_PX]\n"), 2;
    const std::filesystem::path folder = argv[1];
    const int width = argc > 2 ? std::atoi(argv[2]) : 480;
    const int height = static_cast<int>(width * (90 - kLowest_deg) / 360);
    std::filesystem::create_directories(folder);
    for (const double altitude : {60.0, 30.0, 10.0, 3.0, 0.0, -4.0, -8.0, -15.0}) {
        Sheet sheet(3 * width, 2 * height);
        for (int column = 0; column < 3; ++column)
            for (int row = 0; row < 2; ++row) {
                scene::Scene scene;
                scene.sky.turbidity = column == 0 ? 2 : column == 1 ? 3 : 6;
                scene.sky.clouds = row * 0.4;
                const sky::Sky sky({altitude, 180}, scene.sun, scene.sky, 300);
                const voxel::Colour sun =
                    sky.sun_light() * static_cast<float>(std::max(0.0, sky.to_sun().y));
                const voxel::Colour up = sky.ambient({0, 1, 0});
                const voxel::Colour wall = sky.ambient({0, 0, 1});
                std::printf(
                    "sun %5.1f turbidity %.0f clouds %.1f: "
                    "sun %.4g %.4g %.4g, level: sun %.4g, sky %.4g %.4g %.4g (%.0f %%), south wall "
                    "%.3g\n",
                    altitude, scene.sky.turbidity, scene.sky.clouds,
                    static_cast<double>(sky.sun_light().r), static_cast<double>(sky.sun_light().g),
                    static_cast<double>(sky.sun_light().b),
                    static_cast<double>(voxel::luminance(sun)), static_cast<double>(up.r),
                    static_cast<double>(up.g), static_cast<double>(up.b),
                    static_cast<double>(100 * voxel::luminance(up) / voxel::luminance(up + sun)),
                    static_cast<double>(voxel::luminance(wall)));
                draw(sheet, column * width, row * height, width, height, sky);
            }
        const std::string name = "sun_" + std::to_string(static_cast<int>(altitude)) + ".png";
        const std::string bytes = png::encode(sheet.pixels, {sheet.width, sheet.height, 3});
        util::write_file_atomically(folder / name, std::as_bytes(std::span(bytes)));
    }
}
