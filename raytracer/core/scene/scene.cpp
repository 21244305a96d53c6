#include "raytracer/core/scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "common/util/error.hpp"
#include "common/util/numbers.hpp"
#include "common/util/text.hpp"

namespace terravox::scene {
namespace {

/// Takes a number and what follows it from the front of a text.
/// @return nullopt for no number, for one out of range, and where another character follows
std::optional<double> take_number(std::string_view& text, char after) {
    const auto value = util::take_number<double>(text);
    if (!value || !(std::abs(*value) <= PointList::kFarthest))
        return std::nullopt;
    const bool is_right = text.empty() ? after == '\0' : util::take(text, after);
    return is_right ? value : std::nullopt;
}

}  // namespace

std::optional<PointList> PointList::parse(const std::string& text) {
    PointList out;
    std::string_view rest = text;
    while (!rest.empty()) {
        const bool is_last = rest.find(';') == std::string_view::npos;
        const auto x = take_number(rest, ',');
        const auto y = x ? take_number(rest, ',') : std::nullopt;
        const auto z = y ? take_number(rest, is_last ? '\0' : ';') : std::nullopt;
        if (!z || out.points.size() == kMaxPoints || (!is_last && rest.empty()))
            return std::nullopt;
        out.points.push_back({*x, *y, *z});
    }
    return out;
}

std::string PointList::text() const {
    std::string out;
    for (const std::array<double, 3>& point : points)
        for (std::size_t a = 0; a < 3; ++a) {
            if (!out.empty())
                out += a == 0 ? ';' : ',';
            out += util::number_text(point[a]);
        }
    return out;
}

std::optional<TileSize> TileSize::parse(const std::string& text) {
    if (text.ends_with('%')) {
        const auto percent =
            util::parse_number<double>(std::string_view(text).substr(0, text.size() - 1));
        if (!percent || !(*percent >= kMin_percent && *percent <= kMax_percent))
            return std::nullopt;
        return TileSize{TileSize{}.px, *percent};
    }
    const auto px = util::parse_number<int>(text);
    if (!px || *px < 1 || *px > kMax_px)
        return std::nullopt;
    return TileSize{*px, 0};
}

std::string TileSize::text() const {
    if (percent == 0)
        return std::to_string(px);
    return util::number_text(percent) + "%";
}

int TileSize::in_picture(int width_px) const noexcept {
    if (percent == 0)
        return px;
    return static_cast<int>(
        std::clamp(std::floor(width_px * percent / 100 + 0.5), 1.0, static_cast<double>(kMax_px)));
}

void check_is_picture(const Scene& scene) {
    if (scene.analysis.kind != core::AnalysisKind::kNone)
        throw util::UsageError(
            "render: analysis.kind = " + std::string(core::to_word(scene.analysis.kind)) +
            "; allowed for pictures: none; terravox analyse makes rasters");
}

worlds::WorldOptions to_world_options(const Scene& scene) {
    worlds::WorldOptions out;
    out.crs = scene.world.crs;
    out.classes = scene.world.classes;
    out.mark_unknown = scene.world.mark_unknown;
    out.vertical_unit = scene.world.vertical_unit;
    out.settings = scene.world.settings;
    out.steps = scene.world.steps;
    out.photo = scene.world.photo;
    out.voxel_m = scene.world.voxel_m;
    out.dimension = scene.world.dimension;
    out.base_m = scene.world.base_m;
    out.generated = scene.generated;
    out.memory_bytes = static_cast<std::size_t>(scene.world.memory_mib) << 20;
    out.threads = scene.processing.threads.value_or(0);
    out.box_timeout = std::chrono::seconds(scene.processing.box_timeout_s);
    return out;
}

}  // namespace terravox::scene
