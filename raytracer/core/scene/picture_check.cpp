#include "raytracer/core/scene/picture_check.hpp"

#include <string>

#include "common/util/error.hpp"

namespace terravox::scene {

void check_is_picture(const Scene& scene) {
    if (scene.analysis.kind != core::AnalysisKind::kNone)
        throw util::UsageError(
            "render: analysis.kind = " + std::string(core::word_of(scene.analysis.kind)) +
            "; allowed for pictures: none; terravox analyse makes rasters");
}

}  // namespace terravox::scene
