#include <unistd.h>
#include <atomic>
#include <terravox/terravox.hpp>

#include "common/util/error.hpp"
#include "common/util/log.hpp"
#include "common/util/version.hpp"
#include "common/voxel/material.hpp"
#include "raytracer/apps/library/guarded.hpp"
#include "raytracer/core/material/appearance.hpp"

namespace terravox {
namespace {

std::atomic<pid_t> s_first{0};

}  // namespace

bool has_threads_here() noexcept {
    return s_first == ::getpid();
}

void note_process() {
    pid_t none = 0;
    s_first.compare_exchange_strong(none, ::getpid());
    check_process();
}

void check_process() {
    if (s_first != 0 && !has_threads_here())
        throw util::UsageError(
            "use Terravox: this process was forked by one that had used it, and has none of its "
            "threads; allowed: processes that are started anew (in Python: multiprocessing's "
            "methods spawn and forkserver)");
}

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
