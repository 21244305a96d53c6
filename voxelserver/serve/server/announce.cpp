#include "voxelserver/serve/server/announce.hpp"

#include <fmt/format.h>

#include <cmath>
#include <iostream>

#include "common/util/log.hpp"
#include "common/util/printable.hpp"
#include "voxelserver/serve/sockets/http_host.hpp"

namespace terravox::serve {
namespace {

std::string size_text(double bytes) {
    return bytes >= 1e9 ? fmt::format("{:.1f} GB", bytes / 1e9)
                        : fmt::format("{:.0f} MB", bytes / 1e6);
}

std::string crs_text(const voxel::WorldInfo& info) {
    if (!info.crs.empty())
        return info.crs;
    return info.crs_wkt.empty() ? "coordinates of its own" : "a CRS without a name";
}

std::string area_text(const voxel::WorldInfo& info) {
    const auto km = [&](int axis) {
        return (info.bounds.max[static_cast<std::size_t>(axis)] -
                info.bounds.min[static_cast<std::size_t>(axis)]) *
               info.voxel_m / 1000;
    };
    std::string out = fmt::format("{:.2f} x {:.2f} km, {}", km(0), km(2), crs_text(info));
    if (info.centre)
        out += fmt::format(", around {:.4f} {} {:.4f} {}", std::abs(info.centre->lat_deg),
                           info.centre->lat_deg < 0 ? "S" : "N", std::abs(info.centre->lon_deg),
                           info.centre->lon_deg < 0 ? "W" : "E");
    return out;
}

}  // namespace

void announce(const worlds::ServedWorld& world, const Options& options, const Plan& plan,
              const std::string& url) {
    const voxel::WorldInfo& info = world.info();
    const auto say = [](const char* what, const std::string& text) {
        std::cout << fmt::format("  {:<7} {}\n", what, util::printable(text));
    };
    say("world", info.title + ", " + area_text(info));
    say("data", fmt::format("{}; voxels of {} m, levels 0 to {}", world.summary(), info.voxel_m,
                            info.levels - 1));
    if (!info.licence.empty())
        say("licence", info.licence);
    const std::string where =
        plan.boxes.file.empty()
            ? "nothing on disk"
            : fmt::format("{} on disk in {}",
                          size_text(static_cast<double>(options.cache_mib) * 1048576.0),
                          plan.boxes.file.parent_path().string());
    say("boxes",
        std::string(options.prepare ? "all are made now" : "are made on request") +
            fmt::format("; kept: {} of memory in all, {}",
                        size_text(static_cast<double>(options.memory_mib) * 1048576.0), where));
    say("map", url + "/");
    say("stop", "Ctrl-C");
    std::cout << std::flush;
    const std::string& bind = options.server.bind;
    if (!sockets::is_loopback(bind) && plan.token.empty())
        util::log_warn(
            "every client that reaches {} is answered: --token-file requires a token, "
            "config/nginx/ "
            "is a front for open networks",
            bind);
}

}  // namespace terravox::serve
