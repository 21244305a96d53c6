#include "raytracer/core/output/denoise.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "common/util/error.hpp"
#include "raytracer/core/output/oidn_library.hpp"

namespace terravox::output {
namespace {

using Handle = std::unique_ptr<void, void (*)(void*)>;

void check(const OidnLibrary& oidn, void* device) {
    const char* message = nullptr;
    if (oidn.device_error(device, &message) != 0)
        throw util::Error("denoise the picture with " + oidn.file + ": " +
                          (message != nullptr ? message : "it failed and did not say why"));
}

float finite(float v) noexcept {
    return std::isfinite(v) ? v : 0;
}

}  // namespace

void check_can_denoise() {
    (void)OidnLibrary::get();
}

void denoise(Film& film, int threads) {
    if (!film.has_layers())
        throw util::Error("denoise the picture: it has no layers to be guided by");
    const OidnLibrary& oidn = OidnLibrary::get();
    const auto width = static_cast<std::size_t>(film.width_px());
    const auto height = static_cast<std::size_t>(film.height_px());
    std::vector<voxel::Colour> colour;
    std::vector<voxel::Colour> albedo;
    std::vector<voxel::Colour> normal;
    for (auto* plane : {&colour, &albedo, &normal})
        plane->reserve(width * height);
    for (int y = 0; y < film.height_px(); ++y)
        for (int x = 0; x < film.width_px(); ++x) {
            const voxel::Colour& c = film.at(x, y).colour;
            const tiles::LayerSample& l = film.layers_at(x, y);
            colour.push_back({finite(c.r), finite(c.g), finite(c.b)});
            albedo.push_back({std::clamp(l.albedo.r, 0.0f, 1.0f),
                              std::clamp(l.albedo.g, 0.0f, 1.0f),
                              std::clamp(l.albedo.b, 0.0f, 1.0f)});
            normal.push_back({l.normal[0], l.normal[1], l.normal[2]});
        }

    const Handle device(oidn.new_device(OidnLibrary::kCpuDevice), oidn.release_device);
    if (!device)
        throw util::Error("denoise the picture with " + oidn.file +
                          ": it has no way to work on this CPU");
    oidn.set_device_int(device.get(), "numThreads", threads);
    // Other threads of this process must not be crowded out.
    oidn.set_device_bool(device.get(), "setAffinity", false);
    oidn.commit_device(device.get());
    check(oidn, device.get());
    const Handle filter(oidn.new_filter(device.get(), "RT"), oidn.release_filter);
    check(oidn, device.get());
    const auto image = [&](const char* name, std::vector<voxel::Colour>& plane) {
        static_assert(sizeof(voxel::Colour) == 3 * sizeof(float));
        oidn.set_image(filter.get(), name, plane.data(), OidnLibrary::kFloat3, width, height, 0, 0,
                       0);
    };
    image("color", colour);
    image("albedo", albedo);
    image("normal", normal);
    image("output", colour);
    oidn.set_filter_bool(filter.get(), "hdr", true);
    oidn.commit_filter(filter.get());
    oidn.execute_filter(filter.get());
    check(oidn, device.get());
    std::size_t next = 0;
    for (int y = 0; y < film.height_px(); ++y)
        for (int x = 0; x < film.width_px(); ++x)
            film.set_colour(x, y, colour[next++]);
}

}  // namespace terravox::output
