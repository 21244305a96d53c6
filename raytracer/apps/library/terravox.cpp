#include <terravox/terravox.hpp>

#include <atomic>

#include "common/util/log.hpp"
#include "common/util/version.hpp"
#include "common/voxel/material.hpp"
#include "raytracer/apps/library/guarded.hpp"
#include "raytracer/apps/library/log_once.hpp"
#include "raytracer/core/material/material_file.hpp"

namespace terravox {

Error::~Error() = default;
UsageError::~UsageError() = default;
Stopped::~Stopped() = default;

namespace {

std::atomic<bool> s_log_is_set_up{false};

}  // namespace

void set_up_log_once() {
    if (!s_log_is_set_up.exchange(true))
        util::set_up_log("warn");
}

void set_log_level(const std::string& level) {
    guarded([&] { util::set_up_log(level); });
    s_log_is_set_up = true;
}

std::string version() {
    return kVersion;
}

std::vector<Material> materials() {
    return guarded([] {
        const voxel::Palette palette = voxel::load_palette(material::find_materials(""));
        std::vector<Material> out;
        for (const voxel::MaterialTraits& traits : voxel::kMaterialTraits) {
            const voxel::Rgb8 colour = palette.of(traits.material).colour;
            out.push_back({static_cast<std::uint8_t>(traits.material),
                           std::string(traits.name),
                           {colour.r, colour.g, colour.b}});
        }
        return out;
    });
}

}  // namespace terravox
